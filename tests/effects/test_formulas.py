"""Every effect against its formula, written anew: torques, motion, readings, derivatives."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from tests.effects.own_states import IDS
from tests.reference import BENCH, FORMULAS, instant, readings, reference, right_hand_side
from tests.rigs import bench_problem, bench_values, numbers, truth
from tp_jax.effects import Applied, Effect, catalogue, register, unregister
from tp_jax.model import presets
from tp_jax.simulation import simulate

# those with a memory: own_states; those of a measured drive: test_drive_delay
FREE = [e for e in catalogue().values() if e.id not in IDS and not e.reads_later]
every_effect = pytest.mark.parametrize("effect", FREE, ids=[e.id for e in FREE])
DRIFT = (1.0, 0.5)  # of s: middle [s], rate [1/s]
P = BENCH | dict(middle=DRIFT[0], drift=DRIFT[1])
SEEN = ("theta", "f", "d", "spring", "column", "a1", "a2")


def pendulum(effect: Effect | None = None, values=None):
    terms = () if effect is None else (Applied(effect, values),)
    model = presets.double_pendulum(**BENCH, terms=terms)
    return dataclasses.replace(model, drift=DRIFT)


def sizes(effect: Effect, factor: float) -> dict[str, float]:
    """Its amplitudes, a part of their typical sizes, and a value of each shape constant."""
    amplitudes = {a.name: factor * a.typical for a in effect.amplitudes}
    return amplitudes | {s.name: s.grid[len(s.grid) // 2] for s in effect.shapes}


def instants(n: int = 6):
    """Times and states: both bodies sliding either way, and some of them stuck."""
    rng = np.random.default_rng(0)
    for i in range(n):
        y = rng.normal(size=4) * [0.3, 0.6, 4.0, 4.0]
        if i % 4 == 0:
            y[3] = rng.normal() * 1e-5
        if i % 4 == 1:
            y[2] = rng.normal() * 1e-5
        yield rng.uniform(0.0, 2.0), tuple(y)


def at(t, y):
    return jnp.asarray(t), tuple(jnp.asarray(x) for x in y)


def test_every_effect_has_its_formula_here():
    assert {e.id for e in FREE} == set(FORMULAS)


@every_effect
@pytest.mark.parametrize("factor", [1.0, -0.5])
def test_is_its_formula(effect, factor):
    values = sizes(effect, factor)
    model = pendulum(effect, values)
    for t, y in instants():
        m = model.motion(*at(t, y))
        q = instant(P, t, y, effect.id, values)
        for name, value in dict(bearing=q.ML, contact=q.MT, a1=q.a1, a2=q.a2, f=q.f).items():
            assert getattr(m, name) == pytest.approx(value, rel=1e-9, abs=1e-12), name
        y1, y2 = model.readings(*at(t, y))
        assert y1 == pytest.approx(q.y1, rel=1e-10, abs=1e-14)
        assert y2 == pytest.approx(q.y2, rel=1e-10, abs=1e-14)
        rates = model.derivative(*at(t, y))
        np.testing.assert_allclose(rates, q.rate * np.array([q.v1, q.v2, q.a1, q.a2]), rtol=1e-9)


DRY = {
    "bearing_position": ("bearing_dry",),
    "bearing_warmup": ("bearing_dry", "bearing_viscous"),
    "contact_position": ("contact_dry",),
    "contact_vibration": ("contact_dry",),
    "contact_wear": ("contact_dry",),
}


@pytest.mark.parametrize("id", DRY)
@pytest.mark.parametrize("factor", [-20.0, 20.0])
def test_friction_never_drives(id, factor):
    """Whatever a formula says, as on the rig: each amplitude is twenty times its typical size."""
    effect = catalogue()[id]
    values = sizes(effect, factor)
    changes = []
    for t, y in instants(30):
        m = pendulum().motion(*at(t, y))
        friction = sum(getattr(m, name) for name in DRY[id])
        changes.append(float(effect.increment(m, **values) / friction))
    assert min(changes) == pytest.approx(-1.0)
    assert max(changes) > 1.0


@every_effect
def test_amplitude_zero_changes_nothing(effect):
    # not in the last digit: the motion that follows is then the same
    bare, null = pendulum(), pendulum(effect, sizes(effect, 0.0))
    for t, y in instants():
        np.testing.assert_array_equal(null.derivative(*at(t, y)), bare.derivative(*at(t, y)))
        np.testing.assert_array_equal(null.readings(*at(t, y)), bare.readings(*at(t, y)))


@every_effect
def test_derivative_of_the_increment(effect):
    values = sizes(effect, 0.3)
    for t, y in instants(3):
        # the motion without the effect: all that an increment may look at
        m = pendulum().motion(*at(t, y))
        for a in effect.amplitudes:
            f = lambda x, name=a.name, m=m: effect.increment(m, **values | {name: x})  # noqa: E731
            x, h = values[a.name], 1e-5 * a.typical
            _, tangent = jax.jvp(f, (jnp.asarray(x),), (jnp.ones(()),))
            difference = (f(x + h) - f(x - h)) / (2.0 * h)
            assert tangent == pytest.approx(float(difference), rel=1e-6, abs=1e-9)


WHICH = (0, 1, 7, 8, 9)
FAST = {"contact_vibration": 0.06}  # its waves are hardly longer than a step


# What is faster than the samples is never screened (`Effect.resolved`), so its slots are not used.
SLOW = [e for e in FREE if e.resolved(BENCH["omega"], 0.004)]
slow_effect = pytest.mark.parametrize("effect", SLOW, ids=[e.id for e in SLOW])


def test_only_the_motors_steps_are_too_fast():
    assert {e.id for e in FREE} - {e.id for e in SLOW} == {"drive_steps"}
    assert catalogue()["drive_steps"].resolved(3.0, 0.004)


@pytest.fixture(scope="module")
def linearised():
    problem = bench_problem(0.25, WHICH)
    names = tuple(e.qualified(a.name) for e in FREE for a in e.amplitudes)
    out = problem.linearise(bench_values(), problem.initial_states(), names)
    assert out.complete.all()
    return problem.windows, out


@slow_effect
def test_derivative_at_zero(effect, linearised):
    windows, lin = linearised
    for a in effect.amplitudes:
        found, expected = [], []
        for i, (r, first, count) in enumerate(
            zip(windows.recording, windows.first, windows.count, strict=True)
        ):
            ts, y = truth(r)
            ts, y0 = ts[first : first + count], y[first]
            h = 1e-5 * a.typical
            ends = []
            for sign in (1.0, -1.0):
                values = sizes(effect, 0.0) | {a.name: sign * h}
                motion = reference(numbers(r), ts, y0, effect.id, values)
                ends.append(readings(numbers(r), ts, motion, effect.id, values))
            expected.append(((ends[0] - ends[1]) / (2.0 * h)).ravel())
            j = lin.slots.index(effect.qualified(a.name))
            found.append(lin.slots_jac[i, : 2 * count, j])
        found, expected = np.concatenate(found), np.concatenate(expected)
        size = np.linalg.norm(expected)
        # seen: a typical amplitude moves the readings by more than a tenth of their noise
        assert a.typical * size / np.sqrt(size.size * expected.size) > 1e-5
        error = np.linalg.norm(found - expected) / size
        assert error < FAST.get(effect.id, 0.02), f"{a.name}: {error:.4f}"


@slow_effect
def test_derivative_of_the_readings_rates(effect, linearised):
    # the prior's last rows: what the readings' rates are at the start of a window, per recorded
    # second, differentiated by the amplitudes
    windows, lin = linearised
    i, d = 2, 1e-6  # both bodies slide
    r, ts, y0 = windows.recording[i], *(a[windows.first[i]] for a in truth(windows.recording[i]))
    assert np.abs(y0[2:]).min() > 0.1
    for a in effect.amplitudes:
        h, rates = 1e-3 * a.typical, []
        for sign in (1.0, -1.0):
            values = sizes(effect, 0.0) | {a.name: sign * h}
            velocity = np.array(right_hand_side(numbers(r), effect.id, values)(ts, y0))
            t, y = ts + np.array([-d, d]), y0 + np.outer([-d, d], velocity)
            before, after = readings(numbers(r), t, y, effect.id, values)
            rates.append((after - before) / (2.0 * d))
        expected = (rates[0] - rates[1]) / (2.0 * h)
        found = lin.slots_jac[i, -2:, lin.slots.index(effect.qualified(a.name))]
        np.testing.assert_allclose(found * a.typical, expected * a.typical, atol=1e-5, rtol=1e-4)


def test_delayed_channel_reads_an_earlier_angle():
    ts, y = truth(0)
    a = 2e-3
    effect = catalogue()["channel_delay"]
    at_ts = jax.vmap(lambda t, y: jnp.stack(pendulum(effect, {"a": a}).readings(t, tuple(y))))
    read = np.asarray(at_ts(jnp.asarray(ts), jnp.asarray(y)))
    earlier = reference(numbers(0), np.concatenate([[0.0], ts[1:] - a]))
    error = np.abs(read[1:, 1] - earlier[1:, 1]).max()
    assert error < 5e-2 * np.abs(y[1:, 1] - earlier[1:, 1]).max()
    np.testing.assert_array_equal(read[:, 0], y[:, 0])


def test_skewed_clock_stretches_the_recording():
    a = 0.02
    ts = np.linspace(0.0, 1.0, 51)
    skewed = simulate(pendulum(catalogue()["clock_skew"], {"a": jnp.asarray(a)}), ts)
    expected = reference(BENCH, ts / (1.0 + a))
    np.testing.assert_allclose(np.stack(skewed[1:3], axis=1), expected[:, :2], atol=1e-6)
    np.testing.assert_allclose(np.stack(skewed[3:], axis=1), expected[:, 2:], atol=1e-4)


class Relaxing(Effect):
    """A state of its own: a spring torque that follows `-a phi1` with a delay."""

    id = "own_relaxing"
    location = "spring"
    hook = "spring"
    amplitudes = (catalogue()["column_tilt"].amplitudes[0],)
    n_states = 1

    def increment(self, m, a):
        return a * m.z[0]

    def rates(self, m, a):
        return (20.0 * (-m.phi1 - m.z[0]),)


def test_an_effect_from_outside_with_a_state_of_its_own():
    try:
        register(Relaxing)
        effect = catalogue()["own_relaxing"]
        t, y = at(0.3, (0.2, 0.1, 3.0, -2.0, 0.05))
        model = pendulum(effect, {"a": 0.1})
        assert model.n_states == 5
        bare = np.array(pendulum().derivative(t, y[:4]))
        found = np.array(model.derivative(t, y))
        change = np.array([0.0, 0.0, 0.1 * 0.05 / BENCH["B1"], -0.1 * 0.05 / BENCH["B1"]])
        np.testing.assert_allclose(found[:4], bare + change, rtol=1e-12, atol=1e-12)
        assert found[4] == pytest.approx(20.0 * (-0.2 - 0.05))
    finally:
        unregister("own_relaxing")
