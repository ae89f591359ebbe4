"""The engine: many runs in few lanes, each as if it were alone, and as SciPy finds it."""

import functools

import jax
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.reference import BENCH, PAPER, instant, reference
from tp_jax.effects import Amplitude, Applied, Effect
from tp_jax.model import presets
from tp_jax.simulation import simulate
from tp_jax.simulation.control import Control
from tp_jax.simulation.parts import take_apart
from tp_jax.simulation.runs import integrate

# One program for all tests: what differs between them is data.
LANES = 3
TOLERANCE = 1e-8
SLIDING = (0.1, 0.0, 8.0, -12.0)
RUNS = (
    (BENCH, (0.0, 0.0, 0.0, 0.0)),
    (BENCH | dict(eps=1e3), (0.0, 0.0, 0.0, 0.0)),
    (PAPER, (0.0, 0.0, 0.0, 0.0)),
    (PAPER, (0.4, 0.0, -1.0, 2.0)),
    (BENCH, SLIDING),
    (BENCH | dict(eps=1e3), SLIDING),
    (BENCH | dict(omega=60.0, A=0.4), (0.0, 0.5, 0.0, 4.0)),
    (BENCH | dict(B2=1e-3, Tst=-5e-3), (-0.3, 0.0, 2.0, 0.0)),
)
N = len(RUNS)


def times(seed):
    """From 0 to 1 s, unevenly: gaps from a microsecond to a tenth of a second."""
    ts = np.sort(np.random.default_rng(seed).uniform(0.0, 1.0, 64))
    ts = np.concatenate([ts[(ts < 0.3) | (ts > 0.4)][:40], 0.5 + np.array([0.0, 1e-6, 3e-6])])
    return np.unique(np.concatenate([[0.0], ts, [1.0]]))


TS = times(0)


@functools.cache
def program():
    """Runs (parameters (P, N), initial states (4, N), ts, active, max_steps) -> `Ran`."""
    parts = take_apart(presets.get("bench"))

    @jax.jit
    def run(p, y0, ts, active, max_steps):
        q = tuple(p)
        return integrate(
            parts.field,
            q,
            y0,
            ts,
            (q[parts.eps[0]], q[parts.eps[1]]),
            Control(angle=TOLERANCE),
            width=LANES,
            active=active,
            max_steps=max_steps,
        )

    return run


def numbers(runs=RUNS):
    """What the program takes: parameters (P, N) and initial states (4, N)."""
    models = [take_apart(presets.double_pendulum(**p)).values for p, _ in runs]
    return np.array(models, float).T, np.array([y0 for _, y0 in runs]).T


def run(p, y0, ts=TS, active=N, max_steps=1_000_000):
    return jax.tree.map(np.asarray, program()(p, y0, ts, active, max_steps))


@pytest.fixture(scope="module")
def together():
    return run(*numbers())


@pytest.mark.parametrize("i", range(N))
def test_agrees_with_an_independent_integration(together, i):
    expected = reference(RUNS[i][0], TS, RUNS[i][1], rtol=1e-12, atol=1e-13)
    assert together.complete[i]
    # over a run as long as this the error of all steps is that allowed in one, or little more
    np.testing.assert_allclose(together.y[i, :, :2], expected[:, :2], rtol=0.0, atol=3 * TOLERANCE)
    # where friction changes its sign a velocity bends within microseconds
    np.testing.assert_allclose(together.y[i, :, 2:], expected[:, 2:], rtol=0.0, atol=1e-4)


def test_the_runs_stick_slide_and_turn_round(together):
    v1, v2 = together.y[:, :, 2], together.y[:, :, 3]
    assert ((v2[:, 1:] * v2[:, :-1] < 0.0).sum(axis=1) > 2).sum() >= 4
    assert ((v1[:, 1:] * v1[:, :-1] < 0.0).sum(axis=1) > 2).sum() >= 4
    assert (np.abs(v2) < 1e-4).sum() > 20
    assert (np.abs(v2) > 1.0).sum() > 20
    # far from equally long, or the lanes had nothing to hide
    assert together.steps.max() > 2 * together.steps.min()


def test_first_and_last_sample(together):
    np.testing.assert_array_equal(together.y[:, 0], numbers()[1].T)
    longer = run(*numbers(), ts=np.concatenate([TS[:-1], [1.5]]))
    assert np.isfinite(longer.y[:, -1]).all()
    # the last step ends on the last sample, and not a step before or after it
    for i in (0, 4):
        expected = reference(RUNS[i][0], np.array([0.0, 1.5]), RUNS[i][1], rtol=1e-12, atol=1e-13)
        np.testing.assert_allclose(longer.y[i, -1, :2], expected[-1, :2], atol=3 * TOLERANCE)
        np.testing.assert_allclose(longer.y[i, -1, 2:], expected[-1, 2:], atol=1e-5)


def test_where_samples_lie_does_not_matter(together):
    # steps end where samples make them, but the motion is one
    other = times(1)[: TS.size - 1]
    other = np.unique(np.concatenate([other, TS[-4:]]))[: TS.size - 1]
    other = np.concatenate([other, TS[-1:]])
    assert other.size == TS.size
    found = run(*numbers(), ts=other)
    shared, here, there = np.intersect1d(TS, other, return_indices=True)
    assert 2 <= shared.size < TS.size
    a, b = together.y[:, here, :2], found.y[:, there, :2]
    np.testing.assert_allclose(a, b, rtol=0.0, atol=5 * TOLERANCE)


def test_a_queue_of_runs_is_each_alone(together):
    p, y0 = numbers()
    for i in range(N):
        order = np.roll(np.arange(N), -i)
        alone = run(p[:, order], y0[:, order], active=1)
        assert alone.complete.tolist() == [True] + [False] * (N - 1)
        np.testing.assert_allclose(alone.y[0], together.y[i], rtol=0.0, atol=1e-12)
        assert alone.steps[0] == together.steps[i]
        # what is not asked for is not run
        np.testing.assert_array_equal(alone.steps[1:], 0)
        np.testing.assert_array_equal(alone.y[1:, 1:], np.inf)


@pytest.mark.parametrize("order", [np.arange(N)[::-1], np.random.default_rng(3).permutation(N)])
def test_the_order_of_runs_does_not_matter(together, order):
    p, y0 = numbers()
    found = run(p[:, order], y0[:, order])
    np.testing.assert_allclose(found.y, together.y[order], rtol=0.0, atol=1e-12)
    np.testing.assert_array_equal(found.steps, together.steps[order])


def untouched(found, together, lost):
    """All runs but those are as if those had gone well too; those are marked."""
    kept = np.setdiff1d(np.arange(N), lost)
    np.testing.assert_array_equal(found.complete, ~np.isin(np.arange(N), lost))
    np.testing.assert_allclose(found.y[kept], together.y[kept], rtol=0.0, atol=1e-12)
    np.testing.assert_array_equal(found.steps[kept], together.steps[kept])


# among the first to be handed out, from the queue, and last of all, when no run follows
@pytest.mark.parametrize("lost", [[0], [4], [N - 1], [1, 2], [0, 3, N - 2, N - 1]])
def test_a_run_without_numbers_disturbs_no_other(together, lost):
    p, y0 = numbers()
    for j, i in enumerate(lost):
        if j % 2:
            y0[2, i] = np.nan
        else:
            p[take_apart(presets.get("bench")).names.index("spring.k"), i] = np.nan
    found = run(p, y0)
    untouched(found, together, lost)
    assert (found.steps[lost] <= 128).all()  # given up at once
    np.testing.assert_array_equal(found.y[lost, 1:], np.inf)


@pytest.mark.parametrize("i", [0, N - 1])
def test_a_run_that_takes_many_steps_disturbs_no_other(together, i):
    p, y0 = numbers()
    names = take_apart(presets.get("bench")).names
    p[names.index("drive.omega"), i] = 2e4  # shakes the column faster than anything else moves
    hard = run(p, y0)
    assert hard.complete.all()
    assert hard.steps[i] > 20 * together.steps.max()
    expected = reference(RUNS[i][0] | dict(omega=2e4), TS[:3], RUNS[i][1])
    np.testing.assert_allclose(hard.y[i, :3, :2], expected[:, :2], rtol=0.0, atol=1e-6)
    others = np.arange(N) != i
    np.testing.assert_allclose(hard.y[others], together.y[others], rtol=0.0, atol=1e-12)

    given_up = run(p, y0, max_steps=2 * together.steps.max())
    untouched(given_up, together, [i])
    got_to = np.isfinite(given_up.y[i, :, 0]).sum()
    assert 1 <= got_to < TS.size
    np.testing.assert_allclose(given_up.y[i, :got_to], hard.y[i, :got_to], rtol=0.0, atol=1e-12)
    np.testing.assert_array_equal(given_up.y[i, got_to:], np.inf)


@pytest.mark.parametrize("active", [1, 2, LANES, N - 2])
def test_only_the_active_runs_are_run(together, active):
    found = run(*numbers(), active=active)
    np.testing.assert_array_equal(found.complete, np.arange(N) < active)
    np.testing.assert_allclose(found.y[:active], together.y[:active], rtol=0.0, atol=1e-12)
    np.testing.assert_array_equal(found.steps[active:], 0)


class Dahl(Effect):
    """Part of the bearing's dry friction as a bristle: `z' = v1 - |v1| z/z0`."""

    id = "own_dahl"
    location = "bearing"
    hook = "bearing"
    amplitudes = (Amplitude("a", "1"),)
    n_states = 1

    def increment(self, m, a, z0):
        return a * m.M1 * (m.z[0] / z0 - m.sign1)

    def rates(self, m, a, z0):
        return (m.v1 - abs(m.v1) * m.z[0] / z0,)


def test_an_effect_with_a_state_of_its_own():
    a, z0, ts = 0.7, 0.03, np.linspace(0.0, 0.6, 31)
    start = np.array([0.3, 0.0, -2.0, 1.0, 0.01])
    values = {"a": np.array(a), "z0": np.array(z0)}
    model = presets.double_pendulum(**BENCH, terms=(Applied(Dahl(), values),))
    found = simulate(model, ts, start)

    def f(t, y):
        q = instant(BENCH, t, y[:4])
        change = a * q.M1 * (y[4] / z0 - q.S1) / q.B1
        return [q.v1, q.v2, q.a1 - change, q.a2 + change, q.v1 - abs(q.v1) * y[4] / z0]

    expected = solve_ivp(
        f, (0.0, 0.6), start, method="LSODA", t_eval=ts, rtol=1e-11, atol=1e-13, max_step=0.01
    ).y
    np.testing.assert_allclose(found[1:3], expected[:2], rtol=0.0, atol=1e-7)
    np.testing.assert_allclose(found[3:], expected[2:4], rtol=0.0, atol=1e-4)
    # the bristle matters, and it bent both ways
    bare = reference(BENCH, ts, start[:4])
    assert np.abs(bare[:, 0] - expected[0]).max() > 0.01
    assert expected[4].max() > 0.5 * z0
    assert expected[4].min() < -0.5 * z0
