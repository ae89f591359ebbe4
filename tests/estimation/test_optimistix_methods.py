"""Methods of optimistix end where variable projection does."""

import jax.numpy as jnp
import numpy as np
import pytest

from tests.rigs import synthetic_campaign
from tp_jax.estimation import optimistix_methods, variable_projection
from tp_jax.estimation.baseline import prepare_campaign
from tp_jax.estimation.elimination import eliminate
from tp_jax.estimation.ladder import Ladder, problem_of
from tp_jax.estimation.least_squares import parameter
from tp_jax.estimation.linearisation import columns, spread
from tp_jax.estimation.traced_windows import evaluate, traced
from tp_jax.estimation.weak_form import WeakForm


@pytest.fixture(scope="module")
def setting():
    return prepare_campaign(synthetic_campaign(duration=1.5), effects=(), fix={"T0": 4.0})


@pytest.fixture(scope="module")
def problem(setting):
    return problem_of(setting, Ladder(setting).rungs[0])


@pytest.fixture(scope="module")
def start(setting):
    values = WeakForm(setting).start()
    values = values.replace({"eps1": 1e3, "eps2": 1e3})
    return values.replace({"k": 0.9 * values.get("k"), "M1": 1.3 * values.get("M1")})


@pytest.fixture(scope="module")
def reference(setting, problem, start):
    return variable_projection.fit(problem, start, setting.unknowns(), relative=1e-6)


@pytest.mark.parametrize("method", optimistix_methods.SOLVERS)
def test_the_same_optimum(setting, problem, start, reference, method):
    fit = optimistix_methods.fit(problem, start, setting.unknowns(), method=method)
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
    slope = np.array([s.slope(reference.values.get(s.name)) for s in specs])
    jac = spread(lin, unknowns) * slope
    elim = eliminate(lin.r, lin.states_jac, jac)
    made = traced(
        problem, reference.values, reference.states, elim.state_gain, unknowns, specs,
        setting.anchors(), len(problem.blocks()) + 1,
    )  # fmt: skip
    index = [problem.layout.index[s] for s in slots]
    programs = problem.programs
    ids = programs.cover(programs.active(reference.values.table), programs.asked(index))
    r, J = evaluate(problem.layout, problem.tolerances, ids, "linear", made.at, made)
    r, J = np.asarray(r), np.asarray(J)
    assert (r**2).sum() == pytest.approx(lin.cost(), rel=1e-6)
    # states follow: what is left of the Jacobian is what elimination leaves
    np.testing.assert_allclose(J.T @ J, elim.H.sum(axis=0), rtol=1e-3, atol=1e-3)
    assert unknowns[1].name == "k"
    k = reference.values.get("k")
    step = np.zeros(len(unknowns))
    step[1] = specs[1].to_coordinate(1.001 * k) - specs[1].to_coordinate(k)
    moved = problem.linearise(
        reference.values.replace({"k": 1.001 * k}),
        reference.states + elim.state_gain[:, :, 1] * step[1], slots,
    )  # fmt: skip
    other, _ = evaluate(
        problem.layout, problem.tolerances, ids, "linear", made.at + jnp.asarray(step), made
    )
    assert float((np.asarray(other) ** 2).sum()) == pytest.approx(moved.cost(), rel=1e-6)
