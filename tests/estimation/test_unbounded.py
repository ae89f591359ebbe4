"""Coordinates without bounds."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from tp_jax.estimation.unbounded import Unbounded

BOX = Unbounded(np.array([-np.inf, 0.0, -np.inf, 1.0]), np.array([np.inf, np.inf, 2.0, 3.0]))


@pytest.mark.parametrize(
    "x", [[0.3, 0.7, -4.0, 1.2], [-1e3, 1e3, 1.999, 2.999], [0.0, 0.0, 2.0, 1.0]]
)
def test_there_and_back(x):
    np.testing.assert_allclose(BOX.inside(BOX.outside(np.array(x))), x, rtol=1e-9, atol=1e-12)


def test_everything_is_inside():
    v = jnp.asarray(np.random.default_rng(0).normal(size=(200, 4)) * 30.0)
    x = np.asarray(jax.vmap(BOX.inside)(v))
    assert (x >= BOX.lower).all()
    assert (x <= BOX.upper).all()


def test_coordinates_grow_with_the_number():
    x = np.array([0.5, 0.5, 0.5, 1.5])
    _, slope = jax.jvp(BOX.inside, (jnp.asarray(BOX.outside(x)),), (jnp.ones(4),))
    assert (np.asarray(slope) > 0.0).all()
