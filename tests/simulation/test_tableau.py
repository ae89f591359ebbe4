"""ROS34PW2: order conditions, stability, and the order it shows."""

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.linalg import expm

from tp_jax.model import Bearing, Contact, DoubleTorsionPendulum, LinearSpring, SineDrive
from tp_jax.simulation import Rosenbrock
from tp_jax.simulation.rosenbrock import solve_stage
from tp_jax.simulation.tableau import ROS34PW2 as TAB

A, B, ONE = TAB.a, TAB.b, np.ones(4)
G = TAB.g + TAB.gamma * np.eye(4)
C = A @ ONE


def close(value, expected):
    assert value == pytest.approx(expected, abs=1e-14)


def test_order_three_with_the_jacobian():
    # the conditions of a Rosenbrock method; beta = alpha + gamma
    beta = A + G
    close(B @ ONE, 1.0)
    close(B @ beta @ ONE, 1.0 / 2.0)
    close(B @ C**2, 1.0 / 3.0)
    close(B @ beta @ beta @ ONE, 1.0 / 6.0)


def test_order_three_with_any_matrix():
    # Expanded in h with J arbitrary, each tree splits by its edges: those of f' must give what an
    # explicit method needs, those with a J in them nothing.
    close(B @ C, 1.0 / 2.0)
    close(B @ G @ ONE, 0.0)
    close(B @ A @ C, 1.0 / 6.0)
    close(B @ A @ G @ ONE, 0.0)
    close(B @ G @ C, 0.0)
    close(B @ G @ G @ ONE, 0.0)


def test_embedded_order_two_and_no_more():
    low = TAB.b - TAB.b_error
    close(low @ ONE, 1.0)
    close(low @ C, 1.0 / 2.0)
    close(low @ G @ ONE, 0.0)
    assert abs(low @ C**2 - 1.0 / 3.0) > 1e-3


def test_stiffly_accurate_and_damping():
    np.testing.assert_allclose((A + G)[3], B, atol=1e-14)
    np.testing.assert_allclose(TAB.c, [0.0, 2.0 * TAB.gamma, C[2], 1.0], atol=1e-14)
    beta = A + G
    close(1.0 - B @ np.linalg.solve(beta, ONE), 0.0)  # the stability function at infinity
    z = 1j * np.concatenate([-np.geomspace(1e-3, 1e4, 200), np.geomspace(1e-3, 1e4, 200)])
    growth = [1.0 + zi * B @ np.linalg.solve(np.eye(4) - zi * beta, ONE) for zi in z]
    assert np.abs(growth).max() <= 1.0 + 1e-12


def step(f, jacobian, t, y, h):
    """One step by the tableau's definition."""
    inverse = np.linalg.inv(np.eye(y.size) - TAB.gamma * h * jacobian)
    k = np.zeros((4, y.size))
    for i in range(4):
        rhs = f(t + TAB.c[i] * h, y + h * A[i] @ k) + h * jacobian @ (TAB.g[i] @ k)
        k[i] = inverse @ rhs
    return y + h * B @ k, h * TAB.b_error @ k


@pytest.mark.parametrize("matrix", ["exact", "none", "wrong"])
def test_converges_at_order_three_with_any_matrix(matrix):
    exact = lambda t: np.array([np.sin(t), np.exp(-t)])  # noqa: E731

    def f(t, y):  # nonlinear and driven; y = (sin t, exp -t) solves it
        x = y - exact(t)
        return np.array([np.cos(t) + np.sin(x[1]) - x[0] ** 2, -np.exp(-t) - x[0] * y[1]])

    def jacobian(t, y):
        x = y - exact(t)
        true = np.array([[-2.0 * x[0], np.cos(x[1])], [-y[1], -x[0]]])
        return {"exact": true, "none": 0.0 * true, "wrong": np.array([[1.0, -2.0], [0.5, 3.0]])}[
            matrix
        ]

    errors = []
    for n in (40, 80, 160):
        t, y, h = 0.0, exact(0.0), 2.0 / n
        for _ in range(n):
            y, _ = step(f, jacobian(t, y), t, y, h)
            t += h
        errors.append(np.abs(y - exact(2.0)).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    np.testing.assert_allclose(orders, 3.0, atol=0.25)


def linear_pendulum():
    """Both bodies coupled by viscous friction alone, the motor at rest."""
    model = DoubleTorsionPendulum(
        drive=SineDrive(A=0.0, omega=1.0), spring=LinearSpring(40.0), B1=1.0, B2=0.5,
        bearing=Bearing(c1=0.5, M1=0.0, eps=1.0),
        contact=Contact(Tv=0.7, Ts1=0.0, Tst=0.0, T0=1.0, eps=1.0),
    )  # fmt: skip
    acceleration1 = np.array([-40.0, 0.0, -0.5, 0.7])
    acceleration2 = np.array([0.0, 0.0, 0.0, -0.7 / 0.5]) - acceleration1
    return model, np.array([[0, 0, 1, 0], [0, 0, 0, 1], acceleration1, acceleration2])


def test_solver_converges_at_order_three():
    model, matrix = linear_pendulum()
    y0 = np.array([0.3, 0.0, 1.0, -2.0])
    expected = expm(matrix) @ y0
    np.testing.assert_allclose(model.vector_field(jnp.zeros(()), jnp.asarray(y0)), matrix @ y0)
    term = diffrax.ODETerm(model.vector_field)
    step = jax.jit(lambda y, h: Rosenbrock().step(term, 0.0, h, y, None, None, False)[0])
    errors = []
    for n in (100, 200, 400):
        y = jnp.asarray(y0)
        for _ in range(n):
            y = step(y, 1.0 / n)
        errors.append(np.abs(y - expected).max())
    np.testing.assert_allclose(np.log2(np.array(errors[:-1]) / errors[1:]), 3.0, atol=0.1)
    assert errors[-1] < 1e-5


def test_solver_steps_by_the_tableau():
    model, matrix = linear_pendulum()
    y0 = np.array([0.3, 0.0, 1.0, -2.0])
    term = diffrax.ODETerm(model.vector_field)
    y1, error, *_ = Rosenbrock().step(term, 0.0, 0.02, jnp.asarray(y0), None, None, False)
    expected, expected_error = step(lambda t, y: matrix @ y, matrix, 0.0, y0, 0.02)
    np.testing.assert_allclose(y1, expected, rtol=1e-13)
    np.testing.assert_allclose(error, expected_error, rtol=1e-9, atol=1e-16)


@pytest.mark.parametrize("n", [4, 6])
def test_closed_form_of_a_stage_is_the_dense_solve(n):
    rng = np.random.default_rng(n)
    jacobian = rng.normal(size=(n, n)) * 10.0
    jacobian[:2] = 0.0
    jacobian[0, 2] = jacobian[1, 3] = 1.01  # recorded seconds need not be true ones
    rhs = rng.normal(size=n)
    found = solve_stage(jnp.asarray(jacobian), 0.03, jnp.asarray(rhs))
    np.testing.assert_allclose(found, np.linalg.solve(np.eye(n) - 0.03 * jacobian, rhs), rtol=1e-11)
