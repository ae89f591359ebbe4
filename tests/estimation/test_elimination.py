"""Window states eliminated: the Schur complement of the full normal equations."""

import numpy as np
import pytest

from tests.standing_in import standing_in
from tp_jax.estimation.elimination import eliminate, eliminated
from tp_jax.estimation.layout import Unknown
from tp_jax.estimation.linearisation import Linearisation, spread

W, M, U = 5, 40, 7


@pytest.fixture
def system():
    rng = np.random.default_rng(0)
    return rng.normal(size=(W, M)), rng.normal(size=(W, M, 4)), rng.normal(size=(W, M, U))


def normal_equations(r, X, J):
    """Matrix and gradient of all unknowns: states of every window, then those in common."""
    full = np.zeros((W * M, 4 * W + U))
    for w in range(W):
        full[w * M : (w + 1) * M, 4 * w : 4 * w + 4] = X[w]
        full[w * M : (w + 1) * M, 4 * W :] = J[w]
    return full.T @ full, full.T @ r.ravel(), full


def test_sums_are_the_schur_complement(system):
    N, g, _ = normal_equations(*system)
    out = eliminate(*system)
    n = 4 * W
    H = N[n:, n:] - N[n:, :n] @ np.linalg.solve(N[:n, :n], N[:n, n:])
    gradient = g[n:] - N[n:, :n] @ np.linalg.solve(N[:n, :n], g[:n])
    np.testing.assert_allclose(out.H.sum(axis=0), H, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(out.g.sum(axis=0), gradient, rtol=1e-9, atol=1e-9)


def test_each_window_is_projected(system):
    r, X, J = system
    out = eliminate(*system)
    for w in range(W):
        away = np.eye(M) - X[w] @ np.linalg.pinv(X[w])
        np.testing.assert_allclose(out.g[w], J[w].T @ away @ r[w], atol=1e-9)
        np.testing.assert_allclose(out.H[w], J[w].T @ away @ J[w], atol=1e-9)
        assert out.cost[w] == pytest.approx(r[w] @ away @ r[w], rel=1e-9)


def test_the_step_is_that_of_all_unknowns_together(system):
    r = system[0]
    _, _, full = normal_equations(*system)
    step = np.linalg.lstsq(full, -r.ravel())[0]
    out = eliminate(*system)
    common = np.linalg.solve(out.H.sum(axis=0), -out.g.sum(axis=0))
    states = out.state_step + out.state_gain @ common
    np.testing.assert_allclose(common, step[4 * W :], atol=1e-9)
    np.testing.assert_allclose(states.ravel(), step[: 4 * W], atol=1e-9)
    left = ((r.ravel() + full @ step) ** 2).sum()
    assert out.cost.sum() + out.g.sum(axis=0) @ common == pytest.approx(left, rel=1e-9)


def test_a_state_without_influence_does_no_harm(system):
    r, X, J = system
    X[:, :, 3] = 0.0
    out = eliminate(r, X, J)
    assert np.isfinite(out.H).all()
    np.testing.assert_allclose(out.state_step[:, 3], 0.0, atol=1e-9)
    three = eliminate(r, X[:, :, :3], J)
    np.testing.assert_allclose(out.H, three.H, rtol=1e-8, atol=1e-8)


def test_damping_holds_the_states_back(system):
    free, held = eliminate(*system), eliminate(*system, damping=1e6)
    assert np.abs(held.state_step).max() < 1e-4 * np.abs(free.state_step).max()
    assert (held.cost >= free.cost).all()


def test_a_window_in_a_kink_follows_along_it_alone(system):
    r, X, J = system
    kinked = np.array([True, False, True, False, False])
    free, out = eliminate(r, X, J), eliminate(r, X, J, kinked=kinked)
    for name in ("g", "H", "state_step", "state_gain"):
        np.testing.assert_array_equal(getattr(out, name)[~kinked], getattr(free, name)[~kinked])
    for w in np.flatnonzero(kinked):
        slope = X[w].T @ r[w]
        np.testing.assert_allclose(out.state_step[w], 0.0)
        np.testing.assert_allclose(slope @ out.state_gain[w], 0.0, atol=1e-9)
        np.testing.assert_allclose(out.g[w], J[w].T @ r[w], rtol=1e-9)  # as with the state held
        along = np.linalg.svd(slope[None])[2][1:].T  # the three directions without slope
        there = X[w] @ along
        left = J[w] - there @ np.linalg.lstsq(there, J[w], rcond=None)[0]
        np.testing.assert_allclose(out.H[w], left.T @ left, rtol=1e-9, atol=1e-9)


def test_by_slot_is_as_by_unknown():
    """A number of each recording is one column of a window; one at its bound is of no unknown."""
    rng = np.random.default_rng(5)
    recording = np.array([0, 0, 1, 2, 2, 2])
    slots, w, m = ("k", "zero2", "J"), len(recording), 11
    unknowns = (Unknown("J"), Unknown("zero2", 0), Unknown("zero2", 2), Unknown("k"))
    lin = standing_in(
        Linearisation,
        r=rng.normal(size=(w, m)),
        states_jac=rng.normal(size=(w, m, 4)),
        slots_jac=rng.normal(size=(w, m, len(slots))),
        slots=slots,
        recording=recording,
    )
    slope = rng.uniform(0.5, 2.0, size=4)
    kinked = np.array([False, True, False, False, True, False])
    dense = eliminate(lin.r, lin.states_jac, spread(lin, unknowns) * slope, kinked=kinked)
    found = eliminated(lin, unknowns, slope, kinked=kinked)
    for group in (np.zeros(w, int), np.array([0, 1, 1, 2, 0, 2])):
        for mine, theirs in zip(found.sums(group), dense.sums(group), strict=True):
            np.testing.assert_allclose(mine, theirs, atol=1e-12)
    np.testing.assert_allclose(found.summed().H, dense.H.sum(axis=0), atol=1e-12)
    step = rng.normal(size=4)
    expected = dense.state_step + np.einsum("wxu,u->wx", dense.state_gain, step)
    np.testing.assert_allclose(found.following(step), expected, atol=1e-12)
    np.testing.assert_allclose(found.gain_by_unknown(), dense.state_gain, atol=1e-12)
    np.testing.assert_allclose(found.cost, dense.cost)
