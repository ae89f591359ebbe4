"""Copies fitted side by side end where each would end alone, or lower."""

import numpy as np
import pytest

from tp_jax.estimation.variable_projection import fit as fit_windows
from tp_jax.identifiability.copies import Start, fit_copies


@pytest.fixture(scope="module")
def starts(fit):
    """Everything free, k held 1 % too high, Tv held at none."""
    names = [u.name for u in fit.unknowns]
    changes = [{}, {"k": fit.values.get("k") * 1.01}, {"Tv": 0.0}]
    out = []
    for change in changes:
        free = np.array([n not in change for n in names])
        out.append(Start(fit.values.replace(change), fit.states, free))
    return out


@pytest.fixture(scope="module")
def found(fit, starts):
    return fit_copies(fit.problem, fit.unknowns, starts, priors=fit.priors)


def test_each_ends_as_low_as_it_would_alone(fit, starts, found):
    for start, copy in zip(starts, found, strict=True):
        assert copy.converged
        free = [u for u, f in zip(fit.unknowns, start.free, strict=True) if f]
        alone = fit_windows(
            fit.problem,
            start.values,
            free,
            fit.states,
            priors=[a for a in fit.priors if a.unknown in free],
            tolerance=1e-3,
        )
        assert copy.cost <= alone.cost + 0.1 + 1e-5 * alone.cost


def test_what_is_held_stays_to_the_last_digit(fit, found):
    assert found[1].values.get("k") == fit.values.get("k") * 1.01
    assert found[2].values.get("Tv") == 0.0
    assert found[2].values.get("k") != fit.values.get("k")


def test_holding_costs(found):
    assert found[1].cost > found[0].cost + 10.0
    assert found[2].cost > found[0].cost


def test_information_is_that_of_the_fit(fit, found):
    from tp_jax.estimation.fitted import parameter

    slope = np.array(
        [parameter(fit.problem, u).slope(fit.values.get(u.name)) for u in fit.unknowns]
    )
    expected = fit.information() * np.outer(slope, slope)
    scale = np.sqrt(np.diag(expected))
    np.testing.assert_allclose(
        found[0].information / np.outer(scale, scale), expected / np.outer(scale, scale), atol=0.05
    )
