"""Few compiled programs serve the baseline and every effect."""

from tests.rigs import bench_problem, bench_values, whole_layout
from tp_jax.effects import catalogue
from tp_jax.estimation import program
from tp_jax.estimation.layout import Layout
from tp_jax.estimation.problem import DIRECTIONS


def test_a_trace_for_each_group_serves_all():
    layout, values = whole_layout(), bench_values()
    amplitudes = tuple(layout.parameters[i].name for i in layout.amplitudes(frozenset(catalogue())))
    assert len(amplitudes) > 2 * DIRECTIONS
    problem = bench_problem(0.25, (0, 1))
    base = ("k", "A", "c1", "M1", "Ts1")
    # no directions, few, many, and every family of effects
    for slots in (
        (), ("k",), base, ("contact_stribeck.a",), ("spring_asymmetry.a",), ("column_cable.a",),
        ("base_compliance.a",),
    ):  # fmt: skip
        problem.linearise(values, problem.initial_states(), slots)
    program.TRACES, kept = [], program.TRACES
    try:
        for horizon in (0.25, 0.1, 0.05):
            problem = bench_problem(horizon, (0, 1, 2, 3))
            states = problem.initial_states()
            # no direction, the baseline's, every effect's; an effect with an amplitude; other eps
            problem.linearise(values, states, ())
            problem.linearise(values, states, base)
            problem.linearise(values, states + 1e-3, amplitudes)
        present = values.replace({"spring_asymmetry.a": 0.05, "eps1": 1e3, "eps2": 1e3})
        problem.linearise(present, states, ("k", "spring_asymmetry.a"))
        assert program.TRACES == []
    finally:
        program.TRACES = kept


def test_slots_beyond_a_portion_are_the_same_as_alone():
    problem, values = bench_problem(0.25, (1, 9)), bench_values()
    layout = whole_layout()
    amplitudes = tuple(layout.parameters[i].name for i in layout.amplitudes(frozenset(catalogue())))
    states = problem.initial_states()
    every = problem.linearise(values, states, amplitudes).slots_jac
    last = problem.linearise(values, states, amplitudes[-1:]).slots_jac
    scale = abs(last).max()
    assert abs(every[:, :, -1:] - last).max() < 1e-9 * scale


def test_programs_are_kept_for_the_packages_own_effects_only():
    kinds = [type(effect) for effect in catalogue().values()]
    own = tuple(kind() for kind in kinds)
    assert Layout("double", own).described == whole_layout().described
    assert Layout("single", own).described != whole_layout().described
    assert Layout("double", own[1:]).described != whole_layout().described

    class Other(kinds[0]):
        """From outside the package: its source may change."""

    assert Layout("double", (*own[1:], Other())).described is None
