"""One step of the engine against the method's own definition, and what lies inside it."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from tests.simulation.test_tableau import stages
from tp_jax.simulation.step import advance, between, combine, structure
from tp_jax.simulation.tableau import RODAS4

LANES = 3


def field(t, y, p):
    """A pendulum of sorts: nonlinear, driven, with a state of its own."""
    (k, c), (phi1, _, v1, v2, z) = p, y
    drag = jnp.arctan(3.0 * v2)
    a1 = k * (jnp.sin(2.0 * t) - phi1) - c * v1 * v1 + drag + 0.2 * z
    return v1, v2, a1, -1.5 * drag - a1, v1 - jnp.abs(v1) * z


def test_steps_as_the_method_is_defined():
    method = RODAS4
    rng = np.random.default_rng(1)
    t, h = jnp.asarray(rng.uniform(0.0, 2.0, LANES)), jnp.array([1e-4, 0.02, 0.1])
    y, p = jnp.asarray(rng.normal(size=(5, LANES))), jnp.asarray(rng.uniform(0.5, 2.0, (2, LANES)))
    f = field(t, tuple(y), tuple(p))
    made = advance(field, structure(field, 5, 2), method, t, h, list(y), list(f), tuple(p))
    for lane in range(LANES):
        mine = tuple(p[:, lane])
        whole = lambda s, x, mine=mine: jnp.stack(field(s, tuple(x), mine))  # noqa: E731
        end, error = stages(
            method, whole, jax.jacfwd(whole, 1), jax.jacfwd(whole, 0), t[lane], y[:, lane], h[lane]
        )
        np.testing.assert_allclose(np.stack(made.y)[:, lane], end, rtol=1e-12, atol=1e-13)
        np.testing.assert_allclose(np.stack(made.error)[:, lane], error, rtol=1e-8, atol=1e-13)
        np.testing.assert_allclose(
            np.stack(made.f)[:, lane], whole(t[lane] + h[lane], end), rtol=1e-10
        )


def test_sums_leave_out_what_has_no_weight():
    stages = [[jnp.array([1.0])], [jnp.array([jnp.nan])], [jnp.array([3.0])]]
    assert combine(np.array([2.0, 0.0, 1.0, 0.0]), stages, 0) == 5.0


@pytest.mark.parametrize("rate", [1.0, 1.02])  # true seconds per recorded second
def test_inside_a_step_a_quintic_is_exact(rate):
    rng = np.random.default_rng(2)
    h, xs = np.array([0.1, 2.0]), [np.zeros(2), np.array([0.3, 0.8]), np.ones(2)]
    angles = [np.polynomial.Polynomial(rng.normal(size=6)) for _ in range(2)]
    at = lambda t, order: [(q if order == 0 else q.deriv(order))(t) for q in angles]  # noqa: E731
    # velocities and accelerations are by true time, derivatives by recorded time
    state = lambda t: [*at(t, 0), *(v / rate for v in at(t, 1))]  # noqa: E731
    derivatives = lambda t: [*at(t, 1), *(a / rate for a in at(t, 2))]  # noqa: E731
    start = np.zeros(2)
    ends = state(start), derivatives(start), state(h), derivatives(h)
    ends = [[jnp.asarray(x) for x in each] for each in ends]
    for velocities in (True, False):
        found = between(xs, jnp.asarray(h), *ends, rate, velocities)
        for x, values in zip(xs, found, strict=True):
            expected = state(x * h)[: 4 if velocities else 2]
            np.testing.assert_allclose(values, expected, rtol=1e-10, atol=1e-10)
