"""Methods of optimistix end where variable projection does."""

import jax.numpy as jnp
import numpy as np
import pytest

from tests.rigs import synthetic_campaign
from tp_jax.estimation import optimistix_methods, variable_projection
from tp_jax.estimation.elimination import eliminate
from tp_jax.estimation.fitted import parameter
from tp_jax.estimation.linearisation import columns, spread
from tp_jax.estimation.prepared_campaign import prepare_campaign
from tp_jax.estimation.schedule import Schedule, problem_of
from tp_jax.estimation.weak_form import WeakForm
from tp_jax.estimation.window_residuals import window_residuals
from tp_jax.estimation.window_states import settle


@pytest.fixture(scope="module")
def setting():
    return prepare_campaign(synthetic_campaign(duration=1.5), effects=(), fix={"T0": 4.0})


@pytest.fixture(scope="module")
def problem(setting):
    return problem_of(setting, Schedule(setting).rungs[0])


@pytest.fixture(scope="module")
def start(setting):
    values = WeakForm(setting).start()
    values = values.replace({"eps1": 1e3, "eps2": 1e3})
    return values.replace({"k": 0.9 * values.get("k"), "M1": 1.3 * values.get("M1")})


@pytest.fixture(scope="module")
def reference(setting, problem, start):
    return variable_projection.fit(problem, start, setting.unknowns(), relative=1e-6)


# One of residuals and one of their sum; each compiles for half a minute, and `scripts/methods` has
# them all.
@pytest.mark.parametrize("method", ["dogleg", "bfgs"])
def test_the_same_optimum(setting, problem, start, reference, method):
    fit = optimistix_methods.fit(
        problem, start, setting.unknowns(), solver=optimistix_methods.SOLVERS[method]
    )
    assert fit.converged, fit.message
    assert fit.cost == pytest.approx(reference.cost, abs=1.0)
    sd = np.sqrt(np.diag(np.linalg.inv(reference.information())))
    off = (fit.values.pick(fit.unknowns) - reference.values.pick(fit.unknowns)) / sd
    assert np.abs(off[~reference.at_bound]).max() < 0.5


def test_residuals_and_slopes_are_the_windows(setting, problem, reference):
    unknowns = setting.unknowns()
    specs = [parameter(problem, u) for u in unknowns]
    slots = columns(unknowns)
    lin = problem.linearise(reference.values, reference.states, slots)
    x = reference.values.pick(unknowns)
    slope = np.array([s.slope(v) for s, v in zip(specs, x, strict=True)])
    elim = eliminate(lin.r, lin.states_jac, spread(lin, unknowns) * slope)
    f = window_residuals(
        problem,
        reference.values,
        reference.states,
        elim.state_gain,
        unknowns,
        specs,
        setting.priors(),
        blocks=len(problem.blocks()) + 1,
    )
    at = np.array([float(s.to_coordinate(v)) for s, v in zip(specs, x, strict=True)])
    r, J = map(np.asarray, f.evaluate(jnp.asarray(at)))
    assert (r**2).sum() == pytest.approx(lin.cost(), rel=1e-6)
    # states follow: what is left of the Jacobian is what elimination leaves
    np.testing.assert_allclose(J.T @ J, elim.H.sum(axis=0), rtol=1e-3, atol=1e-3)
    assert unknowns[1].name == "k"
    k = reference.values.get("k")
    away = at.copy()
    away[1] = float(specs[1].to_coordinate(1.001 * k))
    values = reference.values.replace({"k": 1.001 * k})
    moved = problem.linearise(values, reference.states, slots)
    settle(problem, values, reference.states, moved, slots)
    other, _ = f.evaluate(jnp.asarray(away))
    assert float((np.asarray(other) ** 2).sum()) == pytest.approx(moved.cost(), abs=0.1)
