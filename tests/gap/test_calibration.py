"""What the calibration may have put off is not credited to an effect, and belongs to the floor.

The model is linear and nothing is integrated: windows of a smooth motion, whose states are angle
and rate at their begin, with derivatives written down here.
"""

import dataclasses
import functools
import types

import numpy as np
import pytest

from tests.rigs import synthetic_campaign
from tests.standing_in import standing_in
from tp_jax.effects import get
from tp_jax.estimation.elimination import eliminate
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.layout import Unknown
from tp_jax.estimation.linearisation import Linearisation
from tp_jax.estimation.prepared_campaign import prepare_campaign
from tp_jax.estimation.problem import Problem
from tp_jax.gap.calibration import columns, floor, noise_alone
from tp_jax.gap.held_out import HeldOut, shrink
from tp_jax.gap.screen import screen
from tp_jax.gap.structure import structure_test
from tp_jax.gap.worth_refitting import worth_refitting
from tp_jax.recordings import CalibrationError

SENSOR, OTHER = "sensor1_nonlinearity.a", "contact_wear.a"
GRID = np.linspace(-1.3, 1.3, 41)
# as of a bridge whose gain is hardly known: a slope, and nearly a sensor's nonlinearity
GAIN = CalibrationError("one", GRID, 0.05 * np.tan(2.0 * GRID / 3.0)[None])


@functools.cache
def campaign(noise=1e-3):
    return synthetic_campaign(noise)


def setting_of(error, off=None):
    """The synthetic campaign, phi1 read with an error, and two effects; nothing is compiled."""
    runs = []
    for r, true in zip(campaign().recordings, campaign(0.0).recordings, strict=True):
        wrong = 0.0 if off is None else off(true.phi1)
        runs.append(dataclasses.replace(r, phi1=r.phi1 + wrong, calibration_error=error))
    effects = [get("sensor1_nonlinearity"), get("contact_wear")]
    return prepare_campaign(
        dataclasses.replace(campaign(), recordings=tuple(runs)), effects=effects
    )


def linear_fit(setting, effect=0.0):
    """A fit of a linear model with one parameter, which knows the motion but for an effect."""
    problem = setting.problem(0.4)
    windows, n = problem.windows, int(problem.windows.count.max())
    m = 2 * n + 4
    r, valid = np.zeros((windows.n, m)), np.zeros((windows.n, m), dtype=bool)
    states_jac = np.zeros((windows.n, m, 4))
    slots = {name: np.zeros((windows.n, m)) for name in ("k", SENSOR, OTHER)}
    for w, (i, first, count) in enumerate(
        zip(windows.recording, windows.first, windows.count, strict=True)
    ):
        data, true = setting.prepared[i], campaign(0.0).recordings[i]
        t = data.t[first : first + count]
        y = np.stack([true.phi1, true.phi2], axis=1)
        rate = np.gradient(y, data.t, axis=0)[first]
        y = y[first : first + count]
        valid[w, : 2 * count] = valid[w, -4:] = True
        for c in range(2):
            rows = slice(c, 2 * count, 2)
            states_jac[w, rows, c], states_jac[w, rows, 2 + c] = 1.0, t - t[0]
            states_jac[w, rows] /= setting.sigma[c]
            for place in (c, 2 + c):
                states_jac[w, -4 + place, place] = 1.0 / data.smooth_sd[first, place]
        angle, rows = y[:, 0], slice(0, 2 * count, 2)
        slots["k"][w, rows] = angle / setting.sigma[0]
        slots["k"][w, [-4, -2]] = np.array([angle[0], rate[0]]) / data.smooth_sd[first, [0, 2]]
        slots[SENSOR][w, rows] = low_at_large(angle) / setting.sigma[0]
        slots[SENSOR][w, -4] = low_at_large(angle[0]) / data.smooth_sd[first, 0]
        slope = np.cos(2.0 * angle[0]) - 1.0
        slots[SENSOR][w, -2] = slope * rate[0] / data.smooth_sd[first, 2]
        slots[OTHER][w, 1 : 2 * count : 2] = np.sin(9.0 * t) * (y[:, 1] > 0.0) / setting.sigma[1]
        r[w, : 2 * count] = ((y - data.y[first : first + count]) / setting.sigma).ravel()
        r[w, -4:] = (np.append(y[0], rate) - data.smooth[first]) / data.smooth_sd[first]
    r -= effect * slots[OTHER]
    jac = np.stack(list(slots.values()), axis=2)

    def linearisation(names):
        which = [list(slots).index(name) for name in names]
        return Linearisation(
            r,
            states_jac,
            jac[..., which],
            valid,
            np.zeros((windows.n, n, 4)),
            np.ones(windows.n, dtype=bool),
            tuple(names),
            windows.recording,
        )

    # to the optimum of the one parameter, as a fit would
    at = eliminate(r, states_jac, jac[..., :1])
    x = -at.g.sum(axis=0) / at.H.sum(axis=0)[:, 0]
    r += jac[..., 0] * x
    at = eliminate(r, states_jac, jac[..., :1])
    r += np.einsum("wmx,wx->wm", states_jac, at.state_step)
    at = eliminate(r, states_jac, jac[..., :1])
    problem = standing_in(
        Problem,
        windows=windows,
        sigma=problem.sigma,
        whiten=problem.whiten,
        layout=problem.layout,
        B1=problem.B1,
        linearise=lambda _values, _states, names: linearisation(names),
    )
    return standing_in(
        Fit,
        problem=problem,
        linearisation=linearisation(["k"]),
        unknowns=(Unknown("k"),),
        at_bound=np.zeros(1, dtype=bool),
        priors=(),
        eliminated=at,
        states=None,
        values=types.SimpleNamespace(replace=lambda _: None),
        normal=at.summed,
        information=lambda: at.H.sum(axis=0),
        dof=2 * int(windows.count.sum()) - 4 * windows.n,
    )


def scored(setting, effect=0.0):
    return {s.id: s for s in screen(linear_fit(setting, effect), setting).scored}


def low_at_large(angle):
    """What a sensor's nonlinearity does at amplitude 1."""
    return 0.5 * np.sin(2.0 * angle) - angle


def wrong(angle):
    """A calibration wrong by one of its standard errors."""
    return GAIN.at(angle)[0]


def test_without_metadata_nothing_changes():
    setting = setting_of({}, wrong)
    fit = linear_fit(setting)
    assert columns(setting, fit).shape[2] == 0
    least = floor(setting, fit, fit)
    assert least.total == least.noise == setting.noise
    assert not least.known
    window = HeldOut(np.full((9, 2), 4e-4), np.full((9, 2), 90.0), fit)
    assert shrink(setting, window, window, 0, least) == shrink(setting, window, window, 0)


def test_columns_are_how_the_readings_move():
    setting = setting_of({"phi1": GAIN})
    fit = linear_fit(setting)
    found = columns(setting, fit)
    assert found.shape[2] == 1  # one calibration for all recordings
    i, first = fit.problem.windows.recording[3], fit.problem.windows.first[3]
    count, data = fit.problem.windows.count[3], setting.prepared[i]
    angle = campaign(0.0).recordings[i].phi1
    assert found[3, : 2 * count : 2, 0] * setting.sigma[0] == pytest.approx(
        wrong(angle[first : first + count]), abs=1e-4
    )
    assert not found[3, 1 : 2 * count : 2].any()
    rate = np.gradient(wrong(angle), data.t)[first]
    start = found[3, -4, 0] * data.smooth_sd[first, 0]
    assert start == pytest.approx(wrong(angle[first]), abs=1e-4)
    assert found[3, -2, 0] * data.smooth_sd[first, 2] == pytest.approx(rate, rel=0.05)


def test_columns_do_not_go_with_the_noise():
    # noise in the angle they are taken at would make them look like the residuals, at a slope of
    # 1/2 by -1/2 per sample
    slope = CalibrationError("one", GRID, 0.5 * GRID[None])
    setting = setting_of({"phi1": slope})
    fit = linear_fit(setting)
    lin, shapes = fit.linearisation, columns(setting, fit)
    elim = eliminate(lin.r, lin.states_jac, np.concatenate([lin.slots_jac, shapes], axis=2))
    H, g = elim.H.sum(axis=0), elim.g.sum(axis=0)
    # the parameter does just that, so that nothing is left but rounding
    left = H[1, 1] - H[1, 0] ** 2 / H[0, 0]
    score = g[1] - H[1, 0] / H[0, 0] * g[0]
    assert abs(score) < 30.0 + 4.0 * np.sqrt(max(left, 0.0))


def test_recordings_with_calibrations_of_their_own_have_errors_of_their_own():
    setting = setting_of({"phi1": GAIN})
    other = {"phi1": dataclasses.replace(GAIN, key="two")}
    runs = list(setting.recordings)
    runs[0] = dataclasses.replace(runs[0], calibration_error=other)
    setting = dataclasses.replace(setting, recordings=tuple(runs))
    found = columns(setting, linear_fit(setting)).any(axis=1)
    assert found.shape[1] == 2
    assert not (found[:, 0] & found[:, 1]).any()


def test_a_calibration_error_is_no_effect_of_the_sensor():
    blind, told = setting_of({}, wrong), setting_of({"phi1": GAIN}, wrong)
    assert scored(blind)["sensor1_nonlinearity"].drop > 100.0
    assert scored(told)["sensor1_nonlinearity"].drop < 10.0
    # what is far beyond the calibration's error still is one, and is as large as it was
    far = setting_of({"phi1": GAIN}, lambda x: 0.1 * low_at_large(x))
    found = scored(far)["sensor1_nonlinearity"]
    assert found.drop > 100.0
    assert found.estimate[0] == pytest.approx(0.1, rel=0.2)


def test_other_effects_are_seen_as_before():
    blind, told = setting_of({}), setting_of({"phi1": GAIN}, wrong)
    before, after = (scored(s, effect=0.004)["contact_wear"] for s in (blind, told))
    assert after.drop == pytest.approx(before.drop, rel=0.05)
    assert after.estimate == pytest.approx(before.estimate, rel=0.05)


def test_a_calibration_error_moves_the_sum_of_all_scores():
    """As its shapes move the fit's unknowns, and with them every effect's score."""
    setting = setting_of({"phi1": GAIN})
    fit = linear_fit(setting)
    known, shapes = screen(fit, setting).by_block, columns(setting, fit).shape[2]
    moved = known.gain[-shapes:]
    assert np.abs(moved).max() > 0.0
    np.testing.assert_allclose(known.dense()[-1], moved.T @ moved, atol=1e-12)


def test_an_effect_of_a_sensor_must_stand_out_to_be_refitted():
    for error, ids in (
        ({}, {"sensor1_nonlinearity", "contact_wear"}),
        ({"phi1": GAIN}, {"contact_wear"}),
    ):
        setting = setting_of(error, wrong)
        seen = screen(linear_fit(setting, effect=0.02), setting)
        found = worth_refitting(setting, seen, structure_test(seen, 0))
        assert {s.id for s in found} == ids


def test_the_floor_is_what_calibration_errors_leave():
    setting = setting_of({"phi1": GAIN})
    fit = linear_fit(setting)
    least = floor(setting, fit, fit)
    assert least.noise == setting.noise
    assert least.calibration["phi2"] == 0.0
    assert least.total["phi1"] == pytest.approx(
        np.hypot(least.noise["phi1"], least.calibration["phi1"])
    )
    rng, misfits, squares = np.random.default_rng(1), [], []
    shape = columns(setting, fit)[..., 0]
    lin = fit.linearisation
    for c in rng.normal(size=400):
        r = c * shape
        at = eliminate(r, lin.states_jac, lin.slots_jac)
        x = -at.g.sum(axis=0) / at.H.sum(axis=0)[:, 0]
        r = r + lin.slots_jac @ x
        r = r + np.einsum(
            "wmx,wx->wm", lin.states_jac, eliminate(r, lin.states_jac, lin.slots_jac).state_step
        )
        misfits.append((r[:, :-4] ** 2).sum() / fit.dof)
        samples = fit.problem.windows.count.sum() - 2 * fit.problem.windows.n
        squares.append(setting.sigma[0] ** 2 * (r[:, :-4:2] ** 2).sum() / samples)
    assert np.mean(misfits) == pytest.approx(least.misfit.sum(), rel=0.3)
    assert np.mean(squares) == pytest.approx(least.calibration["phi1"] ** 2, rel=0.3)
    drawn = least.draws(np.random.default_rng(2), 4000)
    assert drawn.mean() == pytest.approx(0.5 * least.calibration["phi1"] ** 2, rel=0.1)


def test_a_gap_within_the_calibrations_error_is_not_significant():
    setting = setting_of({"phi1": GAIN})
    fit = linear_fit(setting)
    least, count = floor(setting, fit, fit), np.full((40, 2), 100.0)
    left = np.array([least.total["phi1"] ** 2, least.noise["phi2"] ** 2])
    window = HeldOut(1.3 * left * count, count, fit)
    assert shrink(setting, window, window, 0, noise_alone(setting)).significant
    assert not shrink(setting, window, window, 0, least).significant
    wide = HeldOut(100.0 * left * count, count, fit)
    found = shrink(setting, wide, HeldOut(left * count, count, fit), 0, least)
    assert found.value == pytest.approx(1.0)
