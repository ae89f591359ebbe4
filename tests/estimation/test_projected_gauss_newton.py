"""Variable projection as a solver of optimistix."""

import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
import pytest
import scipy.optimize

import tp_jax as tp
from tp_jax.estimation.projected_gauss_newton import damped_step

T = np.linspace(0.0, 4.0, 60)


def rosenbrock(y, args):
    return jnp.array([10.0 * (y[1] - y[0] ** 2), 1.0 - y[0]])


def decays(rates, data):
    """What two exponentials of these logarithms of rates leave of data, their sizes eliminated."""
    basis = jnp.exp(-jnp.exp(rates)[None, :] * T[:, None])
    return data - basis @ jnp.linalg.lstsq(basis, data)[0]


def noisy():
    rng = np.random.default_rng(0)
    return jnp.asarray(3.0 * np.exp(-0.5 * T) + np.exp(-4.0 * T) + 1e-3 * rng.normal(size=T.size))


@pytest.mark.parametrize("start", [(-1.2, 1.0), (3.0, -2.0), (0.0, 0.0)])
def test_it_ends_where_the_residuals_are_zero(start):
    solver = tp.VariableProjection(rtol=0.0, atol=1e-16)
    found = optx.least_squares(rosenbrock, solver, jnp.array(start), max_steps=100)
    np.testing.assert_allclose(found.value, 1.0, atol=1e-6)


def test_a_separable_problem_ends_where_all_methods_do():
    data, start = noisy(), jnp.array([0.5, 0.7])
    mine = optx.least_squares(decays, tp.VariableProjection(0.0, 1e-12), start, data)
    theirs = optx.least_squares(decays, optx.LevenbergMarquardt(1e-10, 1e-10), start, data)
    scipys = scipy.optimize.least_squares(
        lambda y: np.asarray(decays(jnp.asarray(y), data)), np.asarray(start), xtol=1e-12
    )
    np.testing.assert_allclose(mine.value, theirs.value, atol=1e-4)
    np.testing.assert_allclose(mine.value, scipys.x, atol=1e-4)
    assert float(mine.stats["sum_of_squares"]) == pytest.approx(2.0 * scipys.cost, rel=1e-9)
    assert int(mine.stats["num_steps"]) < int(theirs.stats["num_steps"])


def test_pytrees_auxiliary_output_jit_and_vmap():
    def tree(y, args):
        r = rosenbrock(jnp.stack([y["a"], y["b"]]), args)
        return {"first": r[:1], "second": r[1]}, y["a"] + y["b"]

    @jax.jit
    @jax.vmap
    def from_starts(a):
        solver = tp.VariableProjection(0.0, 1e-16)
        found = optx.least_squares(
            tree, solver, {"a": a, "b": jnp.ones_like(a)}, has_aux=True, throw=False
        )
        return found.value["a"], found.value["b"], found.aux

    for each, wanted in zip(from_starts(jnp.array([-1.0, 2.0])), (1.0, 1.0, 2.0), strict=True):
        np.testing.assert_allclose(each, wanted, atol=1e-5)


def test_a_step_into_nowhere_is_refused_and_a_start_there_is_told():
    walled = lambda y, args: jnp.where(y < 3.0, y - 2.9 + 0.2 * y**2, jnp.nan)  # noqa: E731
    found = optx.least_squares(walled, tp.VariableProjection(0.0, 1e-14), jnp.array([-2.4]))
    assert float(walled(found.value, None)[0]) == pytest.approx(0.0, abs=1e-5)
    lost = optx.least_squares(walled, tp.VariableProjection(), jnp.array([4.0]), throw=False)
    assert lost.result == optx.RESULTS.nonfinite


def test_it_ends_where_a_step_promises_too_little():
    data, start = noisy(), jnp.array([0.5, 0.7])
    fine = optx.least_squares(decays, tp.VariableProjection(0.0, 1e-12), start, data)
    rough = optx.least_squares(decays, tp.VariableProjection(0.0, 1e-3), start, data)
    assert int(rough.stats["num_steps"]) < int(fine.stats["num_steps"])
    gained = float(rough.stats["sum_of_squares"] - fine.stats["sum_of_squares"])
    assert 0.0 <= gained < 2e-3


def test_a_direction_without_information_is_not_followed_far():
    H = jnp.array([[2.0, 0.0], [0.0, 0.0]])
    du, promise = damped_step(jnp.array([1.0, 0.0]), H, jnp.array(0.0))
    np.testing.assert_allclose(du, [-0.5, 0.0], atol=1e-9)
    assert float(promise) == pytest.approx(0.5)
