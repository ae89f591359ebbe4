"""RODAS4: stability, and the order that it shows."""

import numpy as np
import pytest

from tp_jax.simulation.tableau import RODAS4


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
    ("problem", "n"),
    [(MildKaps(), 20), (Kaps(), 16), (Driven(), 20)],
    ids=["mild", "stiff", "driven"],
)
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


def test_damps_what_is_stiff():
    form = RODAS4
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
