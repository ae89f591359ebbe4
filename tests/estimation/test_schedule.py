"""The baseline fit finds what made the recordings."""

import dataclasses

import numpy as np
import pytest

from tests.reference import BENCH
from tests.rigs import lossy, synthetic_campaign
from tp_jax.estimation import variable_projection
from tp_jax.estimation.prepared_campaign import prepare_campaign
from tp_jax.estimation.schedule import few_of, fit_over_schedule
from tp_jax.estimation.slow_contact import with_slow_contact
from tp_jax.estimation.start import initial_values
from tp_jax.recordings import Campaign, Recording, load_campaign
from tp_jax.rig import make_campaign
from trials.draw import draw_rig


@pytest.fixture(scope="module")
def setting():
    return prepare_campaign(synthetic_campaign(), effects=())


@pytest.fixture(scope="module")
def fit(setting):
    return fit_over_schedule(setting, initial_values(setting), setting.unknowns())


def test_setting(setting):
    assert setting.fitted == [0, 1, 2]
    assert setting.held_out == []
    np.testing.assert_allclose(setting.sigma, 1e-3, rtol=0.1)
    assert list(setting.horizons) == sorted(setting.horizons)
    assert setting.fixed == {"B1": BENCH["B1"]}
    names = {u.name for u in setting.unknowns()}
    expected = {"B2", "k", "A", "c1", "M1", "Tv", "Ts1", "Tst", "T0", "phase", "zero1"}
    assert names == expected


def test_a_contact_that_rises_too_fast_is_sought_at_the_speeds_that_are_met(setting, fit):
    """Seen on a rig with nothing hidden: from T0 = 389 s/rad no derivative leads to the true 2.

    What was left of the gap passed for a contact that weakens with speed.
    """
    lost = fit.values.replace({"T0": 400.0, "Ts1": fit.values.get("Ts1") + fit.values.get("Tst")})
    how = dict(bounds=setting.bounds, priors=fit.priors, max_iterations=50, relative=1e-7)
    stuck = variable_projection.fit(
        fit.problem, lost, fit.unknowns, fit.states, **{**how, "max_iterations": 0}
    )
    assert stuck.cost > fit.cost + 10.0
    found = with_slow_contact(setting, stuck, variable_projection.fit, how)
    assert found.cost < fit.cost + 1.0
    assert found.values.get("T0") == pytest.approx(fit.values.get("T0"), rel=0.2)


@pytest.mark.parametrize("rest", [0.0, 5.0, 60.0])
def test_a_decay_that_has_come_to_rest_has_about_the_period_of_its_swings(rest):
    """Seen on a rig released by hand whose recording went on for half a minute of stillness.

    Its windows were ten times as long as they ought to be, and the fit ended in another valley.
    """
    t = np.arange(0.0, 4.0 + rest, 0.005)
    rng = np.random.default_rng(0)
    swings = np.exp(-0.8 * t) * np.cos(2.0 * np.pi * t / 0.4) + 0.002 * rng.normal(size=t.size)
    campaign = Campaign.from_arrays([Recording.from_arrays(t, 0.03 + swings)], model="single")
    assert 0.38 < prepare_campaign(campaign).period < 0.9


def test_a_decay_without_a_swing_has_the_period_of_four_quarters():
    """Heavily damped, and still for most of its recording."""
    t = np.arange(0.0, 40.0, 0.005)
    rng = np.random.default_rng(0)
    fall = np.exp(-6.0 * t) * np.cos(2.0 * np.pi * t / 0.8) + 0.002 * rng.normal(size=t.size)
    campaign = Campaign.from_arrays([Recording.from_arrays(t, fall)], model="single")
    assert 0.3 < prepare_campaign(campaign).period < 1.0


def test_a_drive_read_far_from_zero_is_no_other_drive(tmp_path):
    """As counts of a converter: a gain of .001 and 50,000 counts put its rest at 50 rad."""
    make_campaign(tmp_path / "rig", runs=3, duration=3.0, rate=200.0, measured=True, seed=3)
    campaign = load_campaign(tmp_path / "rig")
    counts = [
        r if r.drive is None else dataclasses.replace(r, drive=1e3 * r.drive + 5e4)
        for r in campaign.recordings
    ]
    fits = []
    for one in (campaign, dataclasses.replace(campaign, recordings=tuple(counts))):
        setting = prepare_campaign(one, effects=())
        fits.append(fit_over_schedule(setting, initial_values(setting), setting.unknowns()))
    fit, far = fits
    assert far.values.get("level") < -10.0
    assert far.cost == pytest.approx(fit.cost, rel=1e-3)
    assert far.values.get("k") == pytest.approx(fit.values.get("k"), rel=1e-4)


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
    found = fit_over_schedule(setting, initial_values(setting), setting.unknowns())
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
    found = fit_over_schedule(setting, start, setting.unknowns())
    assert found.converged, found.message
    assert found.values.get("B2") == pytest.approx(parameters.B2, rel=0.02)


@pytest.mark.parametrize("count", [1, 160, 161, 315, 5000])
def test_a_few_of_many_windows_are_spread_at_no_regular_distance(count):
    which = few_of(count)
    assert which.size == min(count, 160)
    assert which[0] >= 0
    assert which[-1] < count
    apart = np.diff(which)
    assert (apart > 0).all()
    if count > 300:
        assert np.unique(apart).size > 2
        assert apart.max() <= 2.1 * count / 160 + 1
