"""ROS34PW2 and RODAS4: order conditions, stability, and the order they show."""

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.linalg import expm

from tp_jax.model import Bearing, Contact, DoubleTorsionPendulum, LinearSpring, SineDrive
from tp_jax.simulation import Rosenbrock
from tp_jax.simulation.rosenbrock import solve_stage
from tp_jax.simulation.tableau import RODAS4, stage_form
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


def stages(form, f, jacobian, rate, t, y, h):
    """One step in stage form, by its definition: state at the end, embedded error."""
    u = np.zeros((len(form.c), y.size))
    for i, c in enumerate(form.c):
        rhs = f(t + c * h, y + form.a[i] @ u) + form.C[i] @ u / h + h * form.d[i] * rate(t, y)
        u[i] = np.linalg.solve(np.eye(y.size) / (form.gamma * h) - jacobian(t, y), rhs)
    return y + form.b @ u, form.b_error @ u


class Kaps:
    """Stiff, with a known solution: order is easily lost where a method is not meant for it."""

    stiffness = 1e8
    end = 1.0

    @staticmethod
    def exact(t):
        return np.array([np.exp(-2.0 * t), np.exp(-t)])

    def f(self, t, y):
        z = self.stiffness
        return np.array([-(z + 2.0) * y[0] + z * y[1] ** 2, y[0] - y[1] - y[1] ** 2])

    def jacobian(self, t, y):
        z = self.stiffness
        return np.array([[-(z + 2.0), 2.0 * z * y[1]], [1.0, -1.0 - 2.0 * y[1]]])

    def rate(self, t, y):
        return np.zeros(2)


class MildKaps(Kaps):
    stiffness = 3.0


class Driven:
    """Nonlinear, and time enters in more than one way; y = (sin t, exp -t) solves it."""

    end = 2.0

    @staticmethod
    def exact(t):
        return np.array([np.sin(t), np.exp(-t)])

    def f(self, t, y):
        x = y - self.exact(t)
        return np.array([np.cos(t) + np.sin(x[1]) - x[0] ** 2, -np.exp(-t) - x[0] * y[1]])

    def jacobian(self, t, y):
        x = y - self.exact(t)
        return np.array([[-2.0 * x[0], np.cos(x[1])], [-y[1], -x[0]]])

    def rate(self, t, y):
        h = 1e-30j  # the complex step
        return self.f(t + h, y).imag / 1e-30


def march(form, problem, n):
    h, y = problem.end / n, problem.exact(0.0)
    for i in range(n):
        y, _ = stages(form, problem.f, problem.jacobian, problem.rate, i * h, y, h)
    return np.abs(y - problem.exact(problem.end)).max()


@pytest.mark.parametrize(
    ("problem", "n"), [(MildKaps(), 20), (Kaps(), 16), (Driven(), 20)],
    ids=["mild", "stiff", "driven"],
)  # fmt: skip
def test_rodas_converges_at_order_four(problem, n):
    errors = np.array([march(RODAS4, problem, m) for m in (n, 2 * n, 4 * n)])
    np.testing.assert_allclose(np.log2(errors[:-1] / errors[1:]), 4.0, atol=0.3)
    assert errors[-1] < 1e-6


def test_rodas_needs_the_derivative_by_time():
    # it is what makes the order above a property of the coefficients and not of the problem
    problem = Driven()
    problem.rate = lambda t, y: np.zeros(2)
    errors = np.array([march(RODAS4, problem, n) for n in (20, 40)])
    assert np.log2(errors[0] / errors[1]) < 3.5


def test_rodas_embedded_order_is_three():
    # over one step: the error of order 4 in the step less that of order 5, but no better
    problem = Driven()
    y, said, true = problem.exact(0.5), [], []
    for h in (0.1, 0.05, 0.025):
        end, error = stages(RODAS4, problem.f, problem.jacobian, problem.rate, 0.5, y, h)
        said.append(np.abs(error).max())
        true.append(np.abs(end - problem.exact(0.5 + h)).max())
    np.testing.assert_allclose(np.diff(np.log2(said)), -4.0, atol=0.4)
    np.testing.assert_allclose(np.diff(np.log2(true)), -5.0, atol=0.5)


def stability(form, z):
    """Growth of `y' = lambda y` over one step, z = lambda h."""
    one = np.ones(len(form.c))
    matrix = np.eye(one.size) / form.gamma - form.C - z * (np.eye(one.size) + form.a)
    return 1.0 + form.b @ np.linalg.solve(matrix, z * one)


@pytest.mark.parametrize("form", [RODAS4, stage_form(TAB)], ids=["RODAS4", "ROS34PW2"])
def test_damps_what_is_stiff(form):
    one = np.ones(len(form.c))
    # the stability function at infinity
    assert 1.0 - form.b @ np.linalg.solve(np.eye(one.size) + form.a, one) == pytest.approx(
        0.0, abs=1e-12
    )
    assert abs(stability(form, -1e9)) < 1e-6
    edge = 1j * np.geomspace(1e-3, 1e4, 300)
    grown = np.abs([stability(form, z) for z in np.concatenate([edge, -edge])])
    assert grown.max() <= 1.0 + 1e-10
    near = 0.1 * np.array([-1.0, 1j, -1.0 + 1j])
    np.testing.assert_allclose([stability(form, z) for z in near], np.exp(near), atol=1e-5)


def test_rodas_is_stiffly_accurate():
    # the last stage is the embedded error, and the step ends where that stage looks
    np.testing.assert_array_equal(RODAS4.a[5, :5], RODAS4.b[:5])
    assert RODAS4.b[5] == RODAS4.b_error[5] == 1.0
    assert RODAS4.c[5] == RODAS4.c[4] == 1.0
    np.testing.assert_array_equal(np.triu(RODAS4.a), 0.0)
    np.testing.assert_array_equal(np.triu(RODAS4.C), 0.0)
    # sums over rows of the first and second kind
    inverse = np.linalg.inv(np.eye(6) / RODAS4.gamma - RODAS4.C)
    np.testing.assert_allclose((RODAS4.a @ inverse).sum(axis=1), RODAS4.c, atol=1e-13)
    np.testing.assert_allclose(inverse.sum(axis=1), RODAS4.d, atol=1e-13)


@pytest.mark.parametrize("wrong", [False, True])
def test_stage_form_takes_the_same_step(wrong):
    rng = np.random.default_rng(0)
    other = np.array([[1.0, -2.0], [0.5, 3.0]])
    problem, form = Driven(), stage_form(TAB)
    assert not form.d.any()  # a W-method asks for no derivative by time
    for _ in range(5):
        t, y = rng.uniform(0.0, 2.0), rng.normal(size=2)
        matrix = other if wrong else problem.jacobian(t, y)
        expected = step(problem.f, matrix, t, y, 0.1)
        found = stages(form, problem.f, lambda *_, m=matrix: m, lambda *_: np.zeros(2), t, y, 0.1)
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-14)
