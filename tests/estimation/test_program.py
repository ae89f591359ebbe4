"""Few compiled programs serve the baseline and every effect."""

import numpy as np

from tests.rigs import bench_problem, bench_values, whole_layout
from tp_jax.effects import Amplitude, Effect, Shape, catalogue
from tp_jax.estimation import program
from tp_jax.estimation.layout import Layout
from tp_jax.estimation.packing import LANES
from tp_jax.estimation.problem import DIRECTIONS
from tp_jax.estimation.program import linearise
from tp_jax.estimation.program_choice import NONE, Programs


def test_a_trace_for_each_group_serves_all():
    layout, values = whole_layout(), bench_values()
    amplitudes = tuple(layout.parameters[i].name for i in layout.amplitudes(frozenset(catalogue())))
    assert len(amplitudes) > 2 * DIRECTIONS
    problem = bench_problem(0.25, (0, 1))
    base = ("k", "A", "c1", "M1", "Ts1")
    # no directions, few, many, and every family of effects
    for slots in (
        (),
        ("k",),
        base,
        ("contact_stribeck.a",),
        ("spring_asymmetry.a",),
        ("column_cable.a",),
        ("base_compliance.a",),
    ):
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
    assert described(Spin, NONE) == program._described(whole_layout(), NONE)
    assert Layout("double", (*catalogue().values(), Spin())).room == whole_layout().room


class Before(Spin):
    """One that comes before it and has a shape constant."""

    id = "a_spin"
    shapes = (Shape("v", "rad/s", (1.0, 2.0)),)

    def increment(self, m, a, v):
        return m.contact_dry * a * m.v2 / v


class Continuous(Before):
    """The same with another constant to estimate."""

    shapes = (Shape("v", "rad/s", (1.0, 2.0), continuous=True),)


def test_where_the_numbers_of_an_effect_from_outside_stand_is_described():
    def described(ids, *kinds):
        own = tuple(kind() for kind in kinds)
        return program._described(Layout("double", (*catalogue().values(), *own)), frozenset(ids))

    assert described({"contact_spin"}, Spin) != described({"contact_spin"}, Before, Spin)
    assert described({"a_spin"}, Before) != described({"a_spin"}, Continuous)


def test_a_program_of_another_layout_is_asked_by_any_slot():
    """What does not carry an effect from outside has no derivative by its amplitude."""
    alone, layout = whole_layout(), Layout("double", (*catalogue().values(), Spin()))
    problem, values = bench_problem(0.25, (0, 1)), bench_values()
    _, _, block = problem.blocks()[0]
    states = np.zeros((problem.capacity, 4, LANES))
    p = np.repeat(values.table[:, :1], LANES, axis=1)
    more = np.concatenate([p, np.zeros((1, LANES))])
    asked = np.array([alone.index["k"], layout.index["contact_spin.a"], *[alone.index["k"]] * 12])
    for own, numbers in ((alone, p), (layout, more)):  # the first one compiles, and serves both
        out = linearise(own, problem.tolerances, NONE, numbers, states, block, asked)
        assert abs(np.asarray(out.jac)[..., 4]).max() > 0.0
        assert not np.asarray(out.jac)[..., 5].any()


def test_what_one_program_holds_is_asked_of_it_at_once():
    """From a refit's first iteration on: a narrow call would be compiled for a single use."""
    layout = whole_layout()
    known, ids = Programs(layout), frozenset({"bearing_drag", "contact_stribeck"})
    known.add(ids)
    base = ("k", "A", "c1", "M1", "Ts1")
    slots = [layout.index[s] for s in (*base, "contact_stribeck.a")]
    asked = []

    def width(program, many):
        asked.append((program, many))
        return 4 if many <= 4 else DIRECTIONS

    found = known.portions(slots, frozenset({"bearing_drag"}), width)
    assert [(sorted(places), program) for places, program in found] == [(list(range(6)), ids)]
    assert (ids, 6) in asked


def test_an_effect_from_outside_has_a_program_of_its_own():
    layout = Layout("double", (*catalogue().values(), Spin()))
    known, mine = Programs(layout), frozenset({"contact_spin"})
    assert mine in layout.families
    assert not mine & known.plain
    cause = frozenset({"bearing_drag"})
    assert known.cover(cause, mine) == cause | mine
    assert known.cover(mine, known.plain) == mine | known.plain
