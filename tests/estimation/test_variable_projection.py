"""Fits with the windows' states projected out end in the same optimum, and sooner."""

import dataclasses

import numpy as np
import pytest
from scipy.optimize import least_squares

from tests.rigs import synthetic_campaign
from tests.standing_in import standing_in
from tp_jax.estimation import variable_projection
from tp_jax.estimation.coordinates import Coordinates
from tp_jax.estimation.elimination import eliminate
from tp_jax.estimation.fitted import parameter
from tp_jax.estimation.linearisation import Linearisation, columns, spread
from tp_jax.estimation.prepared_campaign import prepare_campaign
from tp_jax.estimation.schedule import Schedule, problem_of
from tp_jax.estimation.weak_form import WeakForm
from tp_jax.estimation.window_states import costs, in_turn, of_windows, settle, steps_along_kinks

SLOTS = ("k", "A", "M1", "Ts1")


@pytest.fixture(scope="module")
def setting():
    return prepare_campaign(synthetic_campaign(), effects=())


@pytest.fixture(scope="module")
def schedule(setting):
    return Schedule(setting)


@pytest.fixture(scope="module")
def start(setting):
    return WeakForm(setting).start()


@pytest.fixture(scope="module")
def fit(schedule, start):
    return schedule.run(schedule.first(start).values)


def together(problem, values, unknowns, states, priors):
    """SciPy's least squares over unknowns and window states in one vector.

    Returns:
        values [SI units], sum of squares, evaluations of it.
    """
    space = Coordinates(unknowns, [parameter(problem, u) for u in unknowns])
    size = np.array([0.01, 0.01, 0.1, 0.1])  # of a state
    count, n = len(unknowns), problem.windows.n

    def at(z):
        new = values.put(unknowns, space.values(z[:count]))
        return new, z[count:].reshape(n, 4) * size

    def residuals(z):
        lin = problem.linearise(*at(z), ())
        assert lin.complete.all()
        known = [(z[unknowns.index(a.unknown)] - a.mean) / a.sd for a in priors]
        return np.concatenate([lin.r.ravel(), known])

    def jacobian(z):
        new, where = at(z)
        lin = problem.linearise(new, where, columns(unknowns))
        m = lin.r.shape[1]
        out = np.zeros((n * m + len(priors), z.size))
        by_unknown = spread(lin, unknowns) * space.slope(new.pick(unknowns))
        out[: n * m, :count] = by_unknown.reshape(n * m, count)
        for w in range(n):
            mine = slice(count + 4 * w, count + 4 * w + 4)
            out[w * m : (w + 1) * m, mine] = lin.states_jac[w] * size
        for row, a in enumerate(priors):
            out[n * m + row, unknowns.index(a.unknown)] = 1.0 / a.sd
        return out

    begin = np.concatenate([space.of(values.pick(unknowns)), (states / size).ravel()])
    found = least_squares(residuals, begin, jacobian, x_scale="jac", ftol=1e-6)
    return at(found.x)[0].pick(unknowns), 2.0 * found.cost, found.nfev


def test_the_same_optimum_as_all_unknowns_together(setting, fit):
    x, cost, _ = together(fit.problem, fit.values, fit.unknowns, fit.states, setting.priors())
    assert fit.converged, fit.message
    assert fit.cost <= cost + 1.0
    sd = np.sqrt(np.diag(np.linalg.inv(fit.information())))
    assert np.abs((fit.values.pick(fit.unknowns) - x) / sd).max() < 0.5
    assert fit.chi2_dof == pytest.approx(1.0, abs=0.15)


def test_sooner_than_all_unknowns_together(setting, schedule, start):
    problem = problem_of(setting, schedule.rungs[-1])
    values = start.replace({"eps1": setting.eps, "eps2": setting.eps})
    options = dict(priors=setting.priors(), relative=1e-6)
    mine = variable_projection.fit(problem, values, setting.unknowns(), **options)
    states = problem.initial_states(values)
    _, cost, evaluations = together(problem, values, setting.unknowns(), states, setting.priors())
    assert mine.cost <= cost + 1.0
    assert mine.evaluations <= evaluations


def test_the_gradient_is_zero_there(setting, fit):
    elim = eliminate(
        fit.linearisation.r, fit.linearisation.states_jac, spread(fit.linearisation, fit.unknowns)
    )
    g = elim.g.sum(axis=0)
    for a in setting.priors():
        i = fit.unknowns.index(a.unknown)
        value = fit.values.get(a.unknown.name)
        g[i] += (np.log(value) - a.mean) / a.sd**2 / value
    free = ~fit.at_bound
    H = fit.information()[np.ix_(free, free)]
    assert float(g[free] @ np.linalg.solve(H, g[free])) < 0.1


def test_bounds_hold(setting, schedule, fit):
    k = fit.values.get("k")
    bounds = {"k": (1.02 * k, 2.0 * k)}
    held = variable_projection.fit(
        problem_of(setting, schedule.rungs[0]),
        fit.values,
        setting.unknowns(),
        bounds=bounds,
        priors=setting.priors(),
        max_iterations=4,
    )
    assert held.values.get("k") == 1.02 * k
    assert held.at_bound[[u.name for u in held.unknowns].index("k")]


def test_a_start_that_cannot_be_integrated_says_so(setting, schedule, start, monkeypatch):
    problem = problem_of(setting, schedule.rungs[0])
    lin = problem.linearise(start, problem.initial_states(start), SLOTS)
    lin.complete[0] = False
    monkeypatch.setattr(type(problem), "linearise", lambda *a: lin)
    fit = variable_projection.fit(problem, start, ())
    assert not fit.converged
    assert fit.cost == np.inf
    assert "could not be integrated" in fit.message


# Window states -------------------------------------------------------------------------------


def test_settled_windows_promise_nothing(setting, schedule, fit):
    problem = problem_of(setting, schedule.rungs[0])
    states = problem.initial_states(fit.values)
    lin = problem.linearise(fit.values, states, SLOTS)
    before = costs(lin).copy()
    found = settle(problem, fit.values, states, lin, SLOTS)
    again = problem.linearise(fit.values, found.states, SLOTS)
    np.testing.assert_allclose(costs(found.lin), costs(again), rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(found.lin.slots_jac, again.slots_jac, rtol=1e-5, atol=1e-3)
    assert (costs(again) <= before + 1e-9).all()
    assert costs(again).sum() < 0.9 * before.sum()
    assert 0.0 < found.passes < 8.0
    assert settle(problem, fit.values, found.states, again, SLOTS).passes < 1.5


def test_windows_of_recordings_take_turns(setting):
    windows = setting.problem(setting.horizons[0]).windows
    which = in_turn(windows, np.arange(windows.n))
    assert sorted(which) == list(range(windows.n))
    recording = windows.recording[which]
    assert (np.diff(recording[: 3 * 10]) != 0).all()


def test_some_windows_are_as_among_all(setting, fit):
    problem = setting.problem(setting.horizons[0])
    states = problem.initial_states(fit.values)
    lin = problem.linearise(fit.values, states, SLOTS)
    which = np.array([5, 1, 30, 12])
    part = of_windows(problem, which).linearise(fit.values, states[which], SLOTS)
    np.testing.assert_allclose(costs(part), costs(lin)[which], rtol=1e-6)


def test_a_window_whose_own_step_spoils_the_fit_does_not_end_it(setting, fit, monkeypatch):
    problem = setting.problem(setting.horizons[0])
    begun = fit.values.replace({"k": 1.03 * fit.values.get("k")})
    states = problem.initial_states(begun)
    lin = problem.linearise(begun, states, SLOTS)
    states = settle(problem, begun, states, lin, SLOTS).states
    states[0, 3] += 0.3  # rad/s
    linearise = type(problem).linearise

    def misled(self, *args):
        found = linearise(self, *args)
        first = (self.windows.recording == 0) & (self.windows.first == 0)
        found.states_jac[first] *= -1.0  # the way down is the way up, and its state still follows
        found.slots_jac[first] *= -1.0  # the unknowns as it should
        return found

    monkeypatch.setattr(type(problem), "linearise", misled)
    found = variable_projection.fit(problem, begun, fit.unknowns, states, priors=setting.priors())
    assert found.values.get("k") == pytest.approx(fit.values.get("k"), rel=2e-3)


# Robust losses -------------------------------------------------------------------------------


def test_outliers_move_little_under_a_robust_loss(setting, schedule, fit):
    rng = np.random.default_rng(0)
    prepared = []
    for p in setting.prepared:
        y = p.y.copy()
        hit = rng.random(y.shape) < 0.01
        y[hit] += rng.choice([-0.05, 0.05], hit.sum())
        prepared.append(dataclasses.replace(p, y=y))
    soiled = dataclasses.replace(setting, prepared=tuple(prepared))
    sd = np.sqrt(np.diag(np.linalg.inv(fit.information())))
    off = {}
    for loss in ("linear", "huber", "cauchy"):
        found = schedule.of(soiled) if loss == "linear" else Schedule(soiled, loss=loss)
        x = found.refine(fit).values.pick(fit.unknowns)
        off[loss] = np.abs((x - fit.values.pick(fit.unknowns)) / sd)[:6]
    assert off["linear"].max() > 4.0
    assert off["huber"].max() < 0.5 * off["linear"].max()
    assert off["cauchy"].max() < 2.0


def test_steps_along_kinks_go_down_on_both_sides():
    rng = np.random.default_rng(0)
    X, r = rng.normal(size=(3, 20, 4)), rng.normal(size=(3, 20))
    lin = standing_in(Linearisation, states_jac=X, r=r)
    slope = np.einsum("wmx,wm->wx", X, r)
    step, promise = steps_along_kinks(lin, slope)  # no other side: Gauss-Newton's own
    for w in range(3):
        np.testing.assert_allclose(step[w], -np.linalg.lstsq(X[w], r[w], rcond=None)[0], rtol=1e-6)
    assert (promise > 0.0).all()
    beyond = slope.copy()
    beyond[:, 0] = -5.0 * slope[:, 0]  # the kink is at a value of the first number
    step, promise = steps_along_kinks(lin, beyond)
    np.testing.assert_allclose(np.einsum("wx,wx->w", slope, step), -promise, rtol=1e-6)
    np.testing.assert_allclose(np.einsum("wx,wx->w", beyond, step), -promise, rtol=1e-6)
    np.testing.assert_allclose(step[:, 0], 0.0, atol=1e-9)  # along it
    _, nothing = steps_along_kinks(lin, -slope)  # slopes against each other: nothing to gain
    np.testing.assert_allclose(nothing, 0.0, atol=1e-9)


def test_fits_along_kinks_end_no_higher(setting, fit):
    how = {"priors": setting.priors(), "relative": 1e-6}
    begun = (fit.problem, fit.values, fit.unknowns, fit.states)
    plain = variable_projection.fit(*begun, **how)
    along = variable_projection.fit(*begun, **how, kinks=True)
    assert along.converged, along.message
    assert along.cost <= plain.cost + 0.1
