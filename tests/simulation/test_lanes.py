"""The batch engine: its motion and tangents against the reference, and its packing."""

import dataclasses

import numpy as np
import pytest

from tests.reference import reference
from tests.rigs import bench_problem, bench_values, choose, numbers, truth

WHICH = (0, 1, 7, 8, 9)  # see `test_the_windows_stick_and_turn_round`
NAMES = ("k", "A", "B2", "c1", "M1", "Tv", "Ts1", "Tst", "T0", "phase", "zero1", "zero2")


def motions(problem):
    """True motion (n, 4) and times of each window."""
    w = problem.windows
    for r, first, count in zip(w.recording, w.first, w.count, strict=True):
        ts, y = truth(r)
        yield r, ts[first : first + count], y[first : first + count]


@pytest.fixture(scope="module")
def problem():
    return bench_problem(0.25, WHICH)


@pytest.fixture(scope="module")
def linearised(problem):
    return problem.linearise(bench_values(), problem.initial_states(), NAMES)


def test_the_windows_stick_and_turn_round(problem):
    turned = np.zeros(2, int)
    stuck = slid = began = 0
    for _, _, y in motions(problem):
        turned += (y[1:, 2:] * y[:-1, 2:] < 0.0).sum(axis=0)
        still = np.abs(y[:, 3]) < 1e-3
        stuck += still.sum()
        slid += (np.abs(y[:, 3]) > 1.0).sum()
        began += bool(still.any() and not still.all())
    assert (turned >= 3).all()
    assert stuck > 50
    assert slid > 50
    assert began >= 3


def test_the_motion_is_the_references(problem, linearised):
    assert linearised.complete.all()
    for i, (_, _, y) in enumerate(motions(problem)):
        n = len(y)
        np.testing.assert_allclose(linearised.states[i, :n, :2], y[:, :2], rtol=0.0, atol=1e-4)
        # residuals are the readings less the data, which are the truth
        difference = linearised.states[i, :n, :2] - y[:, :2]
        np.testing.assert_allclose(linearised.r[i, : 2 * n], difference.ravel(), atol=1e-12)
        np.testing.assert_array_equal(linearised.r[i, 2 * n :], 0.0)
        np.testing.assert_array_equal(linearised.valid[i, : 2 * n], True)
        assert not linearised.valid[i, 2 * n : -4].any()


def readings(p, ts, y0):
    y = reference(p, ts, y0, rtol=1e-12, atol=1e-13)[:, :2]
    return y + np.array([p.get("zero1", 0.0), p.get("zero2", 0.0)])


def test_parameter_tangents(problem, linearised):
    for j, name in enumerate(NAMES):
        found, expected = [], []
        for i, (r, ts, y) in enumerate(motions(problem)):
            p = numbers(r)
            now = p.get(name, 0.0)
            h = 1e-6 * (abs(now) or 1.0)
            ends = [readings(p | {name: now + s * h}, ts, y[0]) for s in (1.0, -1.0)]
            expected.append(((ends[0] - ends[1]) / (2.0 * h)).ravel())
            found.append(linearised.slots_jac[i, : 2 * len(ts), j])
        found, expected = np.concatenate(found), np.concatenate(expected)
        error = np.linalg.norm(found - expected) / np.linalg.norm(expected)
        assert error < 0.01, f"{name}: {error:.4f}"


def test_state_tangents(problem, linearised):
    for j in range(4):
        for i, (r, ts, y) in enumerate(motions(problem)):
            e = 1e-8 * np.eye(4)[j]
            ends = [readings(numbers(r), ts, y[0] + s * e) for s in (1.0, -1.0)]
            expected = ((ends[0] - ends[1]) / 2e-8).ravel()
            found = linearised.states_jac[i, : 2 * len(ts), j]
            # a stuck rider forgets its velocity at once: that derivative is next to nothing
            size = max(np.linalg.norm(expected), 0.01 * np.sqrt(expected.size))
            error = np.linalg.norm(found - expected) / size
            assert error < 0.02, f"window {i}, component {j}: {error:.4f}"
            # the prior's rows: smoothed readings and their rates are the state itself
            np.testing.assert_allclose(linearised.states_jac[i, -4:, j], np.eye(4)[j], atol=1e-12)


def test_packing_does_not_matter():
    together = bench_problem(0.1)  # several windows to a lane
    which = (0, 1, 5, 12, 21, 30)
    values, slots = bench_values(), ("k", "Ts1")
    # away from the truth, and some windows disturbed: a neighbour must not feel it
    values = values.replace({"k": 0.47, "Ts1": 0.012})
    states = together.initial_states() + 0.01 * np.random.default_rng(0).normal(
        size=(together.windows.n, 4)
    )
    packed = together.linearise(values, states, slots)
    assert packed.complete.all()
    assert np.bincount(together._places()[:, 2] > 0).tolist()[1] > 10  # not each a lane of its own
    for i in which:
        alone = dataclasses.replace(together, windows=choose(together.windows, [i]))
        one = alone.linearise(values, states[[i]], slots)
        n = 2 * together.windows.count[i]
        for name in ("r", "states_jac", "slots_jac"):
            whole, single = getattr(packed, name)[i], getattr(one, name)[0]
            np.testing.assert_allclose(single[:n], whole[:n], rtol=1e-9, atol=1e-12)
            np.testing.assert_allclose(single[-4:], whole[-4:], rtol=1e-9, atol=1e-12)


def test_order_of_windows_does_not_matter():
    straight = bench_problem(0.1)
    order = np.random.default_rng(1).permutation(straight.windows.n)
    # windows of a recording stay together, or every one would need a lane
    order = order[np.argsort(straight.windows.recording[order], kind="stable")]
    mixed = bench_problem(0.1, order)
    values = bench_values().replace({"c1": 3e-3})
    one = straight.linearise(values, straight.initial_states(), ("c1",))
    two = mixed.linearise(values, mixed.initial_states(), ("c1",))
    np.testing.assert_allclose((two.r**2).sum(axis=1), (one.r**2).sum(axis=1)[order], rtol=1e-9)
    assert two.cost() == pytest.approx(one.cost(), rel=1e-12)


def test_a_hopeless_window_is_marked():
    problem = bench_problem(0.25, WHICH[:2])
    values = bench_values()
    states = problem.initial_states()
    states[0, 2] = np.nan
    out = problem.linearise(values, states, ("k",))
    assert not out.complete[0]
    assert out.complete[1]
    assert out.cost() == np.inf


def test_windows_that_are_placed_anew_give_the_same(problem, linearised, monkeypatch):
    monkeypatch.setattr("tp_jax.estimation.problem.WORTH", np.inf)
    again = dataclasses.replace(problem)
    states = again.initial_states()
    before = again.blocks()
    for _ in range(3):
        found = again.linearise(bench_values(), states, NAMES)
    assert again.blocks() is not before
    for name in ("r", "states_jac", "slots_jac", "states", "valid", "complete"):
        np.testing.assert_array_equal(getattr(found, name), getattr(linearised, name))
