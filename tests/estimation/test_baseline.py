"""The baseline fit finds what made the recordings."""

import numpy as np
import pytest

from tests.reference import BENCH
from tests.rigs import synthetic_campaign
from tp_jax.estimation.baseline import grow, initial_values, prepare_campaign


@pytest.fixture(scope="module")
def setting():
    return prepare_campaign(synthetic_campaign(), effects=())


def test_setting(setting):
    assert setting.fitted == [0, 1, 2]
    assert setting.held_out == []
    np.testing.assert_allclose(setting.sigma, 1e-3, rtol=0.1)
    assert list(setting.horizons) == sorted(setting.horizons)
    assert setting.fixed == {"B1": BENCH["B1"]}
    names = {u.name for u in setting.unknowns()}
    expected = {"B2", "k", "A", "c1", "M1", "Tv", "Ts1", "Tst", "T0", "phase", "zero1"}
    assert names == expected


def test_start_from_the_data_alone(setting):
    start = initial_values(setting)
    for name in ("k", "A", "B2"):
        assert start.get(name) == pytest.approx(BENCH[name], rel=0.3), name
    assert start.get("omega", 0) == 0.0
    assert start.get("omega", 2) == 17.0


def test_baseline_recovers_the_rig(setting):
    fit = grow(setting, initial_values(setting), setting.unknowns())
    assert fit.converged, fit.message
    assert fit.chi2_dof == pytest.approx(1.0, abs=0.15)
    for name in ("k", "A", "B2", "c1", "M1"):
        assert fit.values.get(name) == pytest.approx(BENCH[name], rel=0.03), name
    # of the contact only the sum is known well: dry friction at a middling speed
    friction = [
        v("Tv") * 2.0 + v("Ts1") + v("Tst") * (1.0 - np.exp(-2.0 * v("T0")))
        for v in (fit.values.get, BENCH.get)
    ]
    assert friction[0] == pytest.approx(friction[1], rel=0.03)
    assert abs(fit.values.get("phase")) < 0.01
    assert abs(fit.values.get("zero1")) < 0.002
    # standard errors are honest: nothing that is known lies far from the truth
    names = [u.name for u in fit.unknowns]
    sd = np.sqrt(np.diag(np.linalg.inv(fit.information())))
    for name in ("k", "A", "B2", "c1", "M1"):
        assert abs(fit.values.get(name) - BENCH[name]) < 5.0 * sd[names.index(name)], name
