"""Zeros by structure: found, and never claimed where there is none."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from tp_jax.model import Bearing, LinearSpring, SineDrive, SingleTorsionPendulum, presets
from tp_jax.model.elementary import arctan
from tp_jax.simulation.dependence import dependence
from tp_jax.simulation.parts import take_apart
from tp_jax.simulation.step import structure
from tp_jax.simulation.tangents import curvature

ONE = jax.ShapeDtypeStruct((1,), jnp.float64)


def found(f, n):
    return dependence(f, *[ONE] * n).astype(int).tolist()


def test_what_stands_in_a_formula():
    assert found(lambda a, b, c: (a + b, jnp.sin(c), 2.0 * a, jnp.ones(1)), 3) == [
        [1, 1, 0],
        [0, 0, 1],
        [1, 0, 0],
        [0, 0, 0],
    ]


def test_arguments_and_constants_as_they_are():
    constant = jnp.arange(1.0)
    assert found(lambda a, b: (b, a, constant + 1.0, constant * a, constant), 2) == [
        [0, 1],
        [1, 0],
        [0, 0],
        [1, 0],
        [0, 0],
    ]


def test_through_functions_compiled_on_their_own():
    @jax.jit
    def inner(a, b):
        return b * 2.0, a - 1.0, jax.jit(lambda x: (x, jnp.zeros(1)))(a)

    def f(a, b, c):
        x, y, (z, zero) = inner(a, b)
        return x + c, y, z, zero

    assert found(f, 3) == [[0, 1, 1], [1, 0, 0], [1, 0, 0], [0, 0, 0]]


def test_through_derivatives_of_ones_own():
    @jax.custom_jvp
    def pair(a, b):
        return a * 2.0, b + 1.0

    @pair.defjvp
    def _(primals, tangents):
        return pair(*primals), (tangents[0] * 2.0, tangents[1])

    assert found(pair, 2) == [[1, 0], [0, 1]]
    assert found(lambda a, b: (arctan(a), arctan(b) + a), 2) == [[1, 0], [1, 1]]
    # and through what differentiation makes of them
    slope = lambda a, b: (jax.jvp(arctan, (a,), (jnp.ones(1),))[1], 3.0 * b)  # noqa: E731
    assert found(slope, 2) == [[1, 0], [0, 1]]


def test_a_choice_depends_on_all_it_chooses_from():
    assert found(lambda a, b, c: (jnp.where(a > 0.0, b, c), jnp.where(a > 0.0, 1.0, b)), 3) == [
        [1, 1, 1],
        [1, 1, 0],
    ]


def test_doubt_is_a_yes():
    def loop(a, b):
        return jax.lax.fori_loop(0, 3, lambda _, c: (c[0] + 1.0, c[1] * c[0]), (a, b))

    def branch(a, b):
        return jax.lax.cond(a[0] > 0.0, lambda: (b + 1.0, a), lambda: (b, 2.0 * a))

    # the first does not depend on b, but what is inside a loop is not looked at
    assert found(loop, 2) == [[1, 1], [1, 1]]
    assert found(branch, 2) == [[1, 1], [1, 1]]


def test_the_pendulums_jacobian():
    parts = take_apart(presets.get("bench"))
    s = structure(parts.field, 4, len(parts.values))
    np.testing.assert_array_equal(s.by_time, [0, 0, 1, 1])
    np.testing.assert_array_equal(
        s.by_state, [[0, 0, 1, 0], [0, 0, 0, 1], [1, 0, 1, 1], [1, 0, 1, 1]]
    )
    bends = curvature(parts.field, s, len(parts.values))
    by = {entry: row for entry, row in zip(bends.entries, bends.by_state, strict=True)}
    # friction alone is not linear: its slopes depend on the velocity that they belong to
    np.testing.assert_array_equal(by[2, 0], [0, 0, 0, 0])
    np.testing.assert_array_equal(by[2, 2], [0, 0, 1, 0])
    np.testing.assert_array_equal(by[2, 3], [0, 0, 0, 1])
    of = lambda i: {parts.names[j] for j in np.flatnonzero(bends.field_by_parameter[i])}  # noqa: E731
    assert of(0) == of(1) == set()
    assert {"spring.k", "drive.A", "B1", "B2", "bearing.M1", "contact.T0"} <= of(2)
    assert of(2) | of(3) <= set(parts.names) - {"contact.Ts2", "sensors.zero1", "sensors.zero2"}


def test_the_single_pendulum_has_no_rider():
    model = SingleTorsionPendulum(
        drive=SineDrive(A=0.1, omega=1.0), spring=LinearSpring(1.0), bearing=Bearing(0.1, 0.1, 1e3)
    )
    parts = take_apart(model)
    s = structure(parts.field, 4, len(parts.values))
    np.testing.assert_array_equal(
        s.by_state, [[0, 0, 1, 0], [0, 0, 0, 0], [1, 0, 1, 0], [0, 0, 0, 0]]
    )
    assert parts.eps[0] == parts.eps[1] == parts.names.index("bearing.eps")


@pytest.mark.parametrize("seed", range(5))
def test_a_no_is_certain(seed):
    # a random formula: every derivative that is not zero belongs to a yes
    rng = np.random.default_rng(seed)
    weights = rng.normal(size=(4, 5)) * (rng.random((4, 5)) < 0.4)

    def f(*x):
        mixed = [
            jnp.sin(sum((w * a for w, a in zip(row, x, strict=True) if w), jnp.zeros(1)))
            for row in weights
        ]
        return tuple(jnp.where(m > 0.0, m, arctan(m)) for m in mixed)

    said = dependence(f, *[ONE] * 5)
    jacobian = jax.jacfwd(lambda x: jnp.concatenate(f(*x[:, None])))(rng.normal(size=5))
    np.testing.assert_array_equal(said, np.asarray(jacobian) != 0.0)
