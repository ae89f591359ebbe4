"""Outcomes that the data cannot tell apart."""

import numpy as np

from tp_jax.estimation.optima import groups, indistinguishable
from tp_jax.estimation.outcome import Outcome


def ended(u, cost, chi2_dof=1.0, information=1e4):
    x = np.array([u])
    return Outcome(x, cost, chi2_dof, np.array([[information]]), 1, True, "", cost)


def same(a, b):
    return indistinguishable(a, b, a.x, b.x)


def test_cost_and_place_decide():
    a = ended(0.0, 100.0)
    assert same(a, ended(0.005, 100.5))  # half a standard error
    assert not same(a, ended(0.02, 100.5))
    assert not same(a, ended(0.0, 101.5))
    assert not same(a, ended(0.0, np.inf))
    assert same(a, ended(5.0, 100.0, information=1e-4)) is False
    flat = ended(0.0, 100.0, information=1e-4)
    assert same(flat, ended(5.0, 100.5))  # a direction that nothing tells


def test_misfit_is_the_unit():
    a = ended(0.0, 1000.0, chi2_dof=10.0)
    assert same(a, ended(0.03, 1008.0, chi2_dof=10.0))
    assert not same(a, ended(0.03, 1012.0, chi2_dof=10.0))


def test_the_best_stands_for_the_others():
    outcomes = [ended(0.0, 100.6), ended(1.0, 100.0), ended(0.004, 100.0), ended(1.0, np.inf)]
    assert groups(outcomes, [o.x for o in outcomes]) == [2, 1, 2, 3]
