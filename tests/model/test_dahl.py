"""Dahl's state along a path, and the play in front of it, against SciPy and closed forms."""

import itertools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.rig.dahl import play
from tp_jax.model.dahl import dahl_along, dahl_rate, play_along

Z0 = 0.02


def line(*corners: float, n: int = 2000) -> np.ndarray:
    """A path straight from corner to corner."""
    parts = [np.linspace(a, b, n) for a, b in itertools.pairwise(corners)]
    return np.concatenate([parts[0], *(p[1:] for p in parts[1:])])


def test_rate_is_dahls():
    for v, z in ((2.0, 0.01), (-2.0, 0.01), (0.0, 0.01), (3.0, Z0)):
        assert dahl_rate(jnp.asarray(v), z, Z0) == pytest.approx(v - abs(v) * z / Z0, abs=1e-15)


def test_along_a_path_is_the_solution_of_the_rate():
    ts = np.linspace(0.0, 3.0, 3001)
    x, v = (
        (lambda t: 0.05 * np.sin(4 * t) ** 3),
        (lambda t: 0.6 * np.sin(4 * t) ** 2 * np.cos(4 * t)),
    )
    expected = solve_ivp(
        lambda t, z: v(t) - abs(v(t)) * z / Z0,
        (0.0, 3.0),
        [0.0],
        t_eval=ts,
        rtol=1e-9,
        atol=1e-12,
        max_step=1e-2,
    ).y[0]
    # a turn between two points is missed by less than the path goes there
    np.testing.assert_allclose(dahl_along(jnp.asarray(x(ts)), Z0), expected, atol=1e-6)


def test_a_straight_path_needs_no_points_between():
    dense = line(0.0, 0.03, -0.01)
    ends = dahl_along(jnp.asarray([0.0, 0.03, -0.01]), Z0, 0.004)
    np.testing.assert_allclose(dahl_along(jnp.asarray(dense), Z0, 0.004)[-1], ends[-1], atol=1e-15)
    assert ends[0] == 0.004


def test_starts_stiff_and_slips():
    z = np.asarray(dahl_along(jnp.asarray(line(0.0, 1e-4, 1.0)), Z0))
    assert z[1999] == pytest.approx(1e-4, rel=0.01)
    assert z[-1] == pytest.approx(Z0, rel=1e-12)
    assert np.abs(z).max() <= Z0 * (1.0 + 1e-12)


@pytest.mark.parametrize("half", [0.005, 0.05])
def test_area_of_a_loop(half):
    path = line(0.0, half, *[-half, half] * 20)
    z = np.asarray(dahl_along(jnp.asarray(path), Z0))
    last = slice(-2 * 1999 - 1, None)  # the last turn
    area = np.trapezoid(z[last], path[last])
    assert area == pytest.approx(4 * Z0 * (half - Z0 * np.tanh(half / Z0)), rel=1e-5)


def test_derivative_by_the_length():
    path = jnp.asarray(line(0.0, 0.05, 0.03, n=50))
    found = jax.jacfwd(lambda z0: dahl_along(path, z0))(jnp.asarray(Z0))
    h = 1e-7
    expected = (dahl_along(path, Z0 + h) - dahl_along(path, Z0 - h)) / (2 * h)
    np.testing.assert_allclose(found, expected, atol=1e-6)


def test_play_is_the_operator():
    x = np.cumsum(np.random.default_rng(0).normal(size=800))
    found = play_along(jnp.asarray(x), 2.5)
    np.testing.assert_allclose(found - x[0], play(x - x[0], 2.5), atol=1e-12)


def test_a_body_at_rest_keeps_its_state_through_noise():
    rng = np.random.default_rng(0)
    x = np.concatenate([line(0.0, 0.1, n=200), np.full(2000, 0.1)])
    noisy = jnp.asarray(x + 3e-4 * rng.standard_normal(x.size))
    assert abs(float(dahl_along(noisy, Z0)[-1])) < 0.1 * Z0
    assert dahl_along(play_along(noisy, 1.2e-3), Z0)[-1] == pytest.approx(Z0, rel=0.05)
