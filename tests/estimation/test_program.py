"""Few compiled programs serve the baseline and every effect."""

from tests.rigs import bench_problem, bench_values, whole_layout
from tp_jax.effects import Amplitude, Effect, catalogue
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


def test_programs_are_described_by_what_they_carry():
    kinds = [type(effect) for effect in catalogue().values()]
    own = tuple(kind() for kind in kinds)
    every = frozenset(effect.id for effect in own)
    described = whole_layout().described(every)
    assert Layout("double", own).described(every) == described
    assert Layout("single", own).described(every) != described
    assert Layout("double", own[1:]).described(every) != described
    assert Layout("double", own).described(every - {own[0].id}) != described


class Spin(Effect):
    """An effect from outside the package."""

    id = "contact_spin"
    location = "contact"
    hook = "contact"
    amplitudes = (Amplitude("a", "s^2/rad^2", typical=0.01),)
    factor = 1.0

    def increment(self, m, a):
        return self.factor * m.contact_dry * a * m.v2**2


class Faster(Spin):
    """The same under the same name with another number in its formula."""

    factor = 2.0


def test_an_effect_from_outside_is_described_by_its_formula():
    def described(kind, ids):
        return program._described(Layout("double", (*catalogue().values(), kind())), ids)

    mine = frozenset({"contact_spin"})
    assert described(Spin, mine) == described(Spin, mine)
    assert described(Spin, mine) != described(Faster, mine)
    # what does not carry it is what it was, and finds room for its numbers
    assert described(Spin, program.NONE) == program._described(whole_layout(), program.NONE)
    assert Layout("double", (*catalogue().values(), Spin())).room == whole_layout().room


def test_an_effect_from_outside_has_a_program_of_its_own():
    layout = Layout("double", (*catalogue().values(), Spin()))
    known, mine = program.Programs(layout), frozenset({"contact_spin"})
    assert mine in layout.families
    assert not mine & known.plain
    cause = frozenset({"bearing_drag"})
    assert known.cover(cause, mine) == cause | mine
    assert known.cover(mine, known.plain) == mine | known.plain
