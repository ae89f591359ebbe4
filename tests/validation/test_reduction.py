"""A term that is there stays, one that is not goes."""

import dataclasses

import numpy as np
import pytest

from tests.reference import BENCH, reference
from tests.rigs import synthetic_campaign, synthetic_values
from tests.validation.conftest import fitted
from tp_jax.estimation.baseline import prepare_campaign
from tp_jax.validation import reduction


@pytest.fixture(scope="module")
def plain():
    """The bench without viscous friction anywhere in its contact, and without the rise."""
    campaign = synthetic_campaign(duration=2.0)
    rng = np.random.default_rng(5)
    runs = []
    for r in campaign.recordings:
        p = BENCH | dict(Tv=0.0, Tst=0.0) | (dict(omega=r.omega) if r.forced else dict(A=0.0))
        y0 = np.zeros(4) if r.forced else np.array([1.2, 0.0, 0.0, 0.0])
        y = reference(p, r.t, y0)[:, :2] + 1e-3 * rng.standard_normal((r.t.size, 2))
        runs.append(dataclasses.replace(r, phi1=y[:, 0], phi2=y[:, 1]))
    return fitted(dataclasses.replace(campaign, recordings=tuple(runs)))


def test_what_is_there_stays(right):
    setting, fit = right
    found = reduction(fit, setting)
    assert set(found.free) >= {"c1", "M1"}
    steps = {s.term: s for s in found.steps[0]}
    assert steps["dry bearing"].p < 1e-6
    assert steps["dry bearing"].drop > 100.0
    assert not steps["dry bearing"].left_out


def test_what_is_not_there_goes(plain):
    setting, fit = plain
    found = reduction(fit, setting)
    assert set(found.without) >= {"Tst", "T0"}
    assert {"c1", "M1"} <= set(found.free)
    assert found.values["Tst"] == 0.0
    assert found.values["Ts1"] == pytest.approx(BENCH["Ts1"], rel=0.02)
    assert found.chi2_dof[0] < found.chi2_dof[1] + 0.01
    assert found.to_dict()["without"] == list(found.without)


def test_a_column_alone_has_fewer_terms():
    campaign = synthetic_campaign(duration=2.0)
    single = dataclasses.replace(
        campaign, model="single",
        recordings=tuple(dataclasses.replace(r, phi2=None) for r in campaign.recordings),
    )  # fmt: skip
    setting = prepare_campaign(single, effects=())
    from tp_jax.estimation.least_squares import fit as fit_windows

    values = synthetic_values(setting)
    found = fit_windows(setting.problem(setting.horizons[0]), values, setting.unknowns())
    terms = {s.term for s in reduction(found, setting).steps[0]}
    assert terms == {"viscous bearing", "dry bearing"}
