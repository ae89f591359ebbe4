"""Left-out costs by one Newton step are exact where the model is linear."""

import types

import numpy as np
import pytest

from tests.standing_in import standing_in
from tp_jax.estimation.elimination import eliminate
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.layout import Unknown
from tp_jax.gap.crossvalidation import FOLDS, folds, gain, left_out_cost


def linear_fit(rng, windows=20, m=12, u=3):
    """A fit of a linear model with window states, at its optimum."""
    jac = rng.normal(size=(windows, m, u))
    states = rng.normal(size=(windows, m, 2))
    y = rng.normal(size=(windows, m))
    elim = eliminate(y, states, jac)
    x = -np.linalg.solve(elim.H.sum(axis=0), elim.g.sum(axis=0))
    at = eliminate(y + jac @ x, states, jac)
    cut = types.SimpleNamespace(recording=np.zeros(windows, int), n=windows)
    names = [Unknown(n) for n in ("k", "c1", "M1")]
    spec = types.SimpleNamespace(transform="log", typical=1.0)
    problem = types.SimpleNamespace(
        windows=cut,
        B1=1.0,
        layout=types.SimpleNamespace(
            parameters=[types.SimpleNamespace(scaled=lambda _: spec)] * 3,
            index={"k": 0, "c1": 1, "M1": 2},
        ),
    )
    fit = standing_in(
        Fit,
        problem=problem,
        eliminated=at,
        at_bound=np.zeros(3, bool),
        unknowns=names,
        normal=at.summed,
        information=lambda: at.H.sum(axis=0),
        priors=(),
    )
    return fit, jac, states, y


def test_equals_refitting_without_each_fold():
    fit, jac, states, y = linear_fit(np.random.default_rng(0))
    fold = folds(fit)
    expected = np.zeros(fold.size)
    for k in range(FOLDS):
        rest = fold != k
        elim = eliminate(y[rest], states[rest], jac[rest])
        x = -np.linalg.solve(elim.H.sum(axis=0), elim.g.sum(axis=0))
        out = eliminate(y[~rest] + jac[~rest] @ x, states[~rest], jac[~rest])
        expected[~rest] = out.cost
    assert left_out_cost(fit) == pytest.approx(expected, rel=1e-9)


def test_gain_and_its_error():
    before, after = np.array([4.0, 5.0, 6.0, 7.0]), np.array([1.0, 2.0, 3.0, 4.0])
    drop, error = gain(before, after, np.arange(4))
    assert drop == 12.0
    assert error == pytest.approx(0.0)
