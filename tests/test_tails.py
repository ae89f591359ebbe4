"""Tails against scipy.stats, which takes half a second to load."""

import numpy as np
import pytest
from scipy import stats

from tp_jax import _tails as tails

P, X, DOF = np.array([0.5, 0.05, 1e-6]), np.array([0.1, 3.0, 40.0]), 2.5


@pytest.mark.parametrize(
    ("ours", "theirs"),
    [
        (tails.normal(X[:2]), stats.norm.sf(X[:2])),
        (tails.chi_square_level(P, DOF), stats.chi2.isf(P, DOF)),
        (tails.chi_square_below(X, DOF), stats.chi2.cdf(X, DOF)),
        (tails.chi_square_quantile(P, DOF), stats.chi2.ppf(P, DOF)),
        (tails.noncentral_chi_square(X, DOF, 20.0), stats.ncx2.sf(X, DOF, 20.0)),
        (tails.fisher(X, DOF, 60.0), stats.f.sf(X, DOF, 60.0)),
        (tails.student_level(P, DOF), stats.t.isf(P, DOF)),
        (tails.student_level(P, np.inf), stats.norm.isf(P)),
    ],
)
def test_are_those_of_scipy(ours, theirs):
    np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-15)
