"""The elimination by hand against dense solves by NumPy, one lane after the other."""

import numpy as np
import pytest

from tp_jax.simulation.linear_solve import eliminate

LANES = 5


def random_jacobian(n, density, seed, rider=True):
    """Entries (LANES,), None where zero by structure, and the same as matrices (LANES, n, n)."""
    rng = np.random.default_rng([n, seed])
    rows = [[None] * n for _ in range(n)]
    rows[0][2] = rng.uniform(0.9, 1.1, LANES)  # recorded seconds need not be true ones
    if rider:
        rows[1][3] = rng.uniform(0.9, 1.1, LANES)
    for i in range(2, n):
        for j in range(n):
            if rng.random() < density:
                rows[i][j] = 10.0 * rng.normal(size=LANES)
    dense = np.zeros((LANES, n, n))
    for i, row in enumerate(rows):
        for j, entry in enumerate(row):
            if entry is not None:
                dense[:, i, j] = entry
    return rows, dense


def check(rows, dense, seed):
    n = dense.shape[1]
    rng = np.random.default_rng([7, n, seed])
    g = rng.uniform(50.0, 200.0, LANES)
    solve = eliminate(rows, g)
    for _ in range(2):  # prepared once, for several right-hand sides
        r = rng.normal(size=(n, LANES))
        given = r.copy()
        k = np.stack(solve(list(r)))
        np.testing.assert_array_equal(r, given)
        for lane in range(LANES):
            matrix = g[lane] * np.eye(n) - dense[lane]
            expected = np.linalg.solve(matrix, r[:, lane])
            np.testing.assert_allclose(k[:, lane], expected, rtol=1e-10, atol=1e-13)


@pytest.mark.parametrize("own", [0, 1, 2, 3])
@pytest.mark.parametrize("density", [1.0, 0.7, 0.4, 0.1])
def test_is_the_dense_solve(own, density):
    for seed in range(12):
        rows, dense = random_jacobian(4 + own, density, seed)
        check(rows, dense, seed)


@pytest.mark.parametrize("own", [0, 1])
def test_without_a_rider(own):
    # phi2 does not move at all: row 1 is empty
    for seed in range(4):
        rows, dense = random_jacobian(4 + own, 0.6, seed, rider=False)
        check(rows, dense, seed)


def test_velocities_that_do_not_feel_each_other():
    rows, dense = random_jacobian(4, 1.0, 0)
    for i, j in ((2, 3), (3, 2)):
        rows[i][j] = None
        dense[:, i, j] = 0.0
    for i, j in ((2, 1), (3, 0)):  # nor through the angles
        rows[i][j] = None
        dense[:, i, j] = 0.0
    check(rows, dense, 0)


def test_stiff_friction():
    # a stuck contact: 1e6 1/s against steps of a millisecond, in exact arithmetic no difficulty
    rate = 1e6 * np.array([[-1.0, 0.4], [0.9, -1.4]])
    one = np.ones(LANES)
    rows = [[None, None, one, None], [None, None, None, one]]
    rows += [[-375.0 * one, None, *(r * one for r in rate[0])]]
    rows += [[375.0 * one, None, *(r * one for r in rate[1])]]
    dense = np.zeros((4, 4))
    dense[0, 2] = dense[1, 3] = 1.0
    dense[2:, 0] = -375.0, 375.0
    dense[2:, 2:] = rate
    r = np.array([1.0, -2.0, 3.0, 4.0])
    k = eliminate(rows, 4e3 * one)([x * one for x in r])
    expected = np.linalg.solve(4e3 * np.eye(4) - dense, r)
    np.testing.assert_allclose(np.stack(k)[:, 0], expected, rtol=1e-9)
