"""The baseline fit finds what made the recordings."""

import dataclasses

import numpy as np
import pytest

from tests.reference import BENCH
from tests.rigs import lossy, synthetic_campaign
from tp_jax.blind.draw import draw_rig
from tp_jax.estimation.baseline import grow, initial_values, prepare_campaign
from tp_jax.recordings import load_campaign
from tp_jax.rig import make_campaign


@pytest.fixture(scope="module")
def setting():
    return prepare_campaign(synthetic_campaign(), effects=())


@pytest.fixture(scope="module")
def fit(setting):
    return grow(setting, initial_values(setting), setting.unknowns())


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


def test_baseline_recovers_the_rig(fit):
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


def test_lost_samples_change_nothing(fit):
    campaign = synthetic_campaign()
    # 0.4 s out of the middle, in the last recording but for an island of three samples
    lost = [[(1.3, 1.7)], [(1.3, 1.7)], [(1.3, 1.498), (1.51, 1.7)]]
    runs = [lossy(r, i, *lost[i]) for i, r in enumerate(campaign.recordings)]
    setting = prepare_campaign(dataclasses.replace(campaign, recordings=tuple(runs)), effects=())
    np.testing.assert_allclose(setting.sigma, 1e-3, rtol=0.1)
    found = grow(setting, initial_values(setting), setting.unknowns())
    assert found.converged, found.message
    assert found.chi2_dof == pytest.approx(1.0, abs=0.1)
    sd = np.sqrt(np.diag(np.linalg.inv(found.information())))
    for u, error in zip(found.unknowns, sd, strict=True):
        assert abs(found.values.get(u.name) - fit.values.get(u.name)) < 2.0 * error, u.name
    windows = found.problem.windows
    for r, first, count in zip(windows.recording, windows.first, windows.count, strict=True):
        assert np.diff(setting.prepared[r].t[first : first + count]).max(initial=0.0) < 0.0101


def test_a_rig_whose_rider_hardly_moves_takes_many_steps(tmp_path):
    """Its own data say far too little of the rider, so that the start is a tenth of the truth."""
    parameters, seed, _ = draw_rig(np.random.default_rng([411, 184]), 6, 10.0)
    make_campaign(tmp_path / "rig", parameters, runs=6, seed=seed)
    setting = prepare_campaign(load_campaign(tmp_path / "rig"), effects=())
    start = initial_values(setting)
    assert start.get("B2") < 0.3 * parameters.B2
    found = grow(setting, start, setting.unknowns())
    assert found.converged, found.message
    assert found.values.get("B2") == pytest.approx(parameters.B2, rel=0.02)
