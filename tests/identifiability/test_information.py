"""What a fit knows of its parameters."""

import numpy as np

from tp_jax.identifiability.information import information


def test_standard_deviations_are_those_of_the_information(fit, setting):
    found = information(fit, setting)
    assert found.names == tuple(u.name for u in fit.unknowns)
    # the guard on T0 apart, it is the fit's own matrix
    H = fit.eliminated.H.sum(axis=0) / max(fit.chi2_dof, 1.0)
    np.testing.assert_allclose(found.sd, np.sqrt(np.diag(np.linalg.inv(H))), rtol=1e-4)


def test_correlation(fit, setting):
    found = information(fit, setting)
    np.testing.assert_allclose(np.diag(found.correlation), 1.0)
    np.testing.assert_allclose(found.correlation, found.correlation.T, atol=1e-9)
    place = found.names.index
    # dry friction and what of it rises with speed are known better together than alone
    assert found.correlation[place("Ts1"), place("Tst")] < -0.8


def test_no_direction_of_a_good_fit_is_unknown_but_the_rise(fit, setting):
    for d in information(fit, setting).directions:
        assert d.kind == "practical"
        assert set(d.coefficients) <= {"Tst", "T0", "Ts1", "Tv"}
