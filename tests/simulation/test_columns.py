"""Columns of a Jacobian are those of JAX, and without what is zero."""

import sys

import jax
import jax.numpy as jnp
import numpy as np
from jax.extend.core import Jaxpr

from tp_jax.simulation.columns import columns, some_columns


@jax.jit
def inner(x, y):
    return jnp.where(x > 0.0, x * y, y - x), jnp.sin(y)


def f(x, y, z, unused):
    a, b = inner(x, y)
    return a - b, z**2, (x - z) + unused * 0.0 + 1.0, jnp.concatenate([b[:1], a[1:]])


def test_columns_are_jax_own():
    rng = np.random.default_rng(0)
    at = tuple(jnp.asarray(rng.normal(size=5)) for _ in range(4))
    found = columns(f, at, (0, 1, 2))
    for k, column in enumerate(found):
        tangents = tuple(jnp.ones(5) * (i == k) for i in range(4))
        expected = jax.jvp(f, at, tangents)[1]
        for one, other in zip(column, expected, strict=True):
            np.testing.assert_allclose(0.0 if one is None else one, other, atol=1e-14)


def test_nothing_is_asked_of_jaxpr_but_to_be_read(monkeypatch):
    """From JAX 0.11.2 on `Jaxpr.replace` ignores new constants."""
    replace = Jaxpr.replace

    def refused(*given, **changes):
        assert sys._getframe(1).f_globals["__name__"] != columns.__module__
        return replace(*given, **changes)

    monkeypatch.setattr(Jaxpr, "replace", refused)
    test_columns_are_jax_own()


def test_zeros_are_known():
    at = tuple(jnp.ones(3) for _ in range(4))
    by_x, by_z = columns(f, at, (0, 2))
    assert by_x[1] is None
    assert by_z[0] is None
    assert by_z[3] is None
    assert columns(f, at, ()) == []


def test_under_jit():
    at = tuple(jnp.linspace(0.1, 1.0, 4) for _ in range(4))
    (plain,) = columns(f, at, (1,))
    (compiled,) = jax.jit(lambda *at: columns(f, at, (1,)))(*at)
    for one, other in zip(plain, compiled, strict=True):
        assert (one is None) == (other is None)
        if one is not None:
            np.testing.assert_allclose(one, other, rtol=1e-14)


def test_chosen_columns_are_those_of_all():
    rng = np.random.default_rng(1)
    at = tuple(jnp.asarray(rng.normal(size=5)) for _ in range(4))
    wanted = np.ones((4, 3), bool)
    wanted[0, 1] = wanted[3] = False

    def chosen(which):
        return some_columns(f, at, (0, 1, 2), which, wanted)

    found = jax.jit(chosen)(jnp.array([2, 1, 3, 2]))
    assert found[3] is None
    every = columns(f, at, (0, 1, 2))
    for i, rows in enumerate(found[:3]):
        for row, j in zip(rows, (2, 1, 3, 2), strict=True):
            column = every[j][i] if j < 3 and wanted[i, j] else None
            np.testing.assert_allclose(row, 0.0 if column is None else column, atol=1e-14)
