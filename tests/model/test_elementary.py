"""Arctangent, sine, cosine against NumPy, and their derivatives against what formulas say."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tp_jax.model.elementary import arctan, cosine, sine

RNG = np.random.default_rng(0)
# of every size, and dense where the arctangent changes its formula: tan(pi/16), 1
NUMBERS = np.concatenate(
    [
        RNG.uniform(-3.0, 3.0, 20_000),
        RNG.choice([-1.0, 1.0], 20_000) * 10.0 ** RNG.uniform(-300.0, 300.0, 20_000),
        np.tan(np.pi / 16.0) + np.spacing(0.2) * np.arange(-20, 21),
        1.0 + np.spacing(1.0) * np.arange(-20, 21),
    ]
)
compiled = {f.__name__: jax.jit(f) for f in (arctan, sine, cosine)}
slopes = {f.__name__: jax.jit(jax.vmap(jax.grad(f))) for f in (arctan, sine, cosine)}
bends = {f.__name__: jax.jit(jax.vmap(jax.grad(jax.grad(f)))) for f in (arctan, sine, cosine)}


def eight(size):
    """One shape, so that one program serves all examples; XLA takes subnormal numbers for zero."""
    number = st.floats(-size, size, allow_subnormal=False)
    return st.lists(number, min_size=8, max_size=8).map(np.array)


def units(found, expected):
    """Greatest error in units of the last place."""
    return np.max(np.abs(found - expected) / np.spacing(np.abs(expected)))


@pytest.mark.parametrize("f", [arctan, compiled["arctan"]], ids=["plain", "compiled"])
def test_arctan_to_all_digits(f):
    found = np.asarray(f(NUMBERS))
    np.testing.assert_allclose(found, np.arctan(NUMBERS), rtol=0.0, atol=4e-16)
    assert units(found, np.arctan(NUMBERS)) <= 4.0


@given(x=eight(1e308))
def test_arctan_of_anything(x):
    found = np.asarray(compiled["arctan"](x))
    np.testing.assert_allclose(found, np.arctan(x), rtol=1e-15, atol=0.0)
    np.testing.assert_array_equal(compiled["arctan"](-x), -found)


def test_arctan_at_its_ends():
    special = np.array([0.0, -0.0, np.inf, -np.inf, np.nan])
    np.testing.assert_array_equal(arctan(special)[:4], np.arctan(special)[:4])
    assert np.isnan(arctan(special)[4])
    np.testing.assert_array_equal(slopes["arctan"](special[:4]), [1.0, 1.0, 0.0, 0.0])
    # what a stuck body creeps by keeps its digits
    assert arctan(1e-20) == 1e-20


def test_derivatives_of_arctan():
    x = NUMBERS[np.abs(NUMBERS) < 1e60]
    np.testing.assert_allclose(slopes["arctan"](x), 1.0 / (1.0 + x * x), rtol=1e-15)
    np.testing.assert_allclose(bends["arctan"](x), -2.0 * x / (1.0 + x * x) ** 2, rtol=1e-14)


@pytest.mark.parametrize("f", [sine, compiled["sine"]], ids=["plain", "compiled"])
def test_sine_up_to_a_million_radians(f):
    for size in (1.0, 10.0, 1e3, 1e6):
        x = RNG.uniform(-size, size, 20_000)
        np.testing.assert_allclose(f(x), np.sin(x), rtol=0.0, atol=4e-16)
    tiny = NUMBERS[np.abs(NUMBERS) < 0.1]
    assert units(np.asarray(f(tiny)), np.sin(tiny)) <= 4.0


def test_sine_at_its_zeros():
    # what is left of a multiple of pi, in which all leading digits cancel
    x = np.arange(-2000, 2001) * np.pi / 2.0
    np.testing.assert_allclose(compiled["sine"](x), np.sin(x), rtol=0.0, atol=4e-16)
    np.testing.assert_array_equal(sine(np.array([0.0, 1e-300])), [0.0, 1e-300])
    assert np.isnan(sine(jnp.asarray(np.inf)))
    assert np.isnan(sine(jnp.asarray(np.nan)))


@given(x=eight(1e6))
def test_sine_of_anything(x):
    found = np.asarray(compiled["sine"](x))
    np.testing.assert_allclose(found, np.sin(x), rtol=0.0, atol=4e-16)
    np.testing.assert_allclose(slopes["sine"](x), np.cos(x), rtol=0.0, atol=4e-16)


def test_derivatives_of_sine():
    x = RNG.uniform(-10.0, 10.0, 1000)
    np.testing.assert_allclose(slopes["sine"](x), np.cos(x), rtol=0.0, atol=4e-15)
    np.testing.assert_allclose(bends["sine"](x), -np.sin(x), rtol=0.0, atol=8e-15)
    assert slopes["sine"](np.zeros(1)) == 1.0


@pytest.mark.parametrize("f", [cosine, compiled["cosine"]], ids=["plain", "compiled"])
def test_cosine_up_to_a_million_radians(f):
    for size in (1.0, 10.0, 1e3, 1e6):
        x = RNG.uniform(-size, size, 20_000)
        np.testing.assert_allclose(f(x), np.cos(x), rtol=0.0, atol=4e-16)
    assert f(np.zeros(1)) == 1.0


def test_cosine_at_its_zeros():
    x = np.arange(-2000, 2001) * np.pi / 2.0
    np.testing.assert_allclose(compiled["cosine"](x), np.cos(x), rtol=0.0, atol=4e-16)
    assert np.isnan(cosine(jnp.asarray(np.inf)))
    assert np.isnan(cosine(jnp.asarray(np.nan)))


def test_derivatives_of_cosine():
    x = RNG.uniform(-10.0, 10.0, 1000)
    np.testing.assert_allclose(slopes["cosine"](x), -np.sin(x), rtol=0.0, atol=4e-16)
    np.testing.assert_allclose(bends["cosine"](x), -np.cos(x), rtol=0.0, atol=4e-16)


@pytest.mark.parametrize("f", [arctan, sine, cosine])
def test_shapes_are_kept(f):
    assert f(jnp.zeros(())).shape == ()
    assert f(jnp.zeros((2, 3))).shape == (2, 3)
    assert f(jnp.zeros((2, 3))).dtype == jnp.float64
