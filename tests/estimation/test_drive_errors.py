"""Drives whose readings are noisy are put right by the angles, as far as noise may be wrong."""

import dataclasses

import numpy as np
import pytest

from tests import noisy
from tp_jax.estimation.drive_errors import with_drives_of_angles
from tp_jax.estimation.from_readings import fit_from_readings
from tp_jax.estimation.intervals import covariance
from tp_jax.estimation.prepared_campaign import prepare_campaign
from tp_jax.estimation.schedule import fit_over_schedule
from tp_jax.estimation.start import initial_values
from tp_jax.gap.held_out import evaluate, squares
from tp_jax.recordings.drive_noise import periodic
from tp_jax.rig import BENCH

OMEGAS = (11.0, 13.0, 15.0)  # rad/s; near resonance, where a phase moves the column most
RATE, NOISE, DRIVE_NOISE, GAIN = 100.0, 1.5e-4, 1.5e-2, 0.02


def campaign(late: float = 0.0, seed: int = 0, measured: bool = True):
    """Three driven runs of good angles, the drive read in counts, `late` seconds after them."""
    rng = np.random.default_rng(seed)
    whole = noisy.campaign(lambda rng, y, run: y, 0, (RATE,) * 4)
    runs = []
    for omega in OMEGAS:
        t, y = noisy.motion(omega, RATE)
        y = y + NOISE * rng.standard_normal(y.shape)
        drive = BENCH.A * (np.sin(omega * (t - late)) + DRIVE_NOISE * rng.standard_normal(t.size))
        runs.append(
            dataclasses.replace(
                whole.recordings[1],
                name=f"run-{omega:.0f}.csv",
                label=f"run-{omega:.0f}",
                t=t,
                phi1=y[:, 0],
                phi2=y[:, 1],
                drive=drive / GAIN + 300.0 if measured else None,
                omega=None if measured else omega,
            )
        )
    return dataclasses.replace(whole, recordings=tuple(runs))


def fitted(runs):
    setting = prepare_campaign(runs)
    return setting, fit_over_schedule(setting, initial_values(setting), setting.unknowns())


def phase(t, drive, omega):
    """Phase [rad] of a drive that was sin(omega t)."""
    waves = np.column_stack([np.sin(omega * t), np.cos(omega * t), np.ones(t.size)])
    a, b, _ = np.linalg.lstsq(waves, drive, rcond=None)[0]
    return float(np.arctan2(b, a))


@pytest.fixture(scope="module")
def put_right():
    """Before and after."""
    setting, baseline = fitted(campaign())
    return setting, baseline, *with_drives_of_angles(setting, baseline)


def test_angles_put_the_phases_right(put_right):
    setting, baseline, found, fit = put_right
    before = [phase(r.t, r.drive, w) for r, w in zip(setting.recordings, OMEGAS, strict=True)]
    after = [phase(r.t, r.drive, w) for r, w in zip(found.recordings, OMEGAS, strict=True)]
    assert np.abs(before).max() > 4e-4
    assert np.abs(after).max() < 0.4 * np.abs(before).max()
    # twelve numbers take twelve of noise
    assert fit.cost < baseline.cost - 50.0


def test_drives_that_were_put_right_are_not_asked_again(put_right):
    _, _, found, fit = put_right
    assert with_drives_of_angles(found, fit) == (found, fit)
    # one that was refused is
    others = {i: drive for i, drive in found.drives.items() if i}
    again, _ = with_drives_of_angles(dataclasses.replace(found, drives=others), fit)
    assert set(again.drives) >= set(others)
    for i in others:
        np.testing.assert_array_equal(again.recordings[i].drive, found.recordings[i].drive)


def test_intervals_know_that_drives_are_estimates(put_right):
    _, _, found, fit = put_right
    taken_as_read = dataclasses.replace(found, drives={})
    wide, narrow = (np.sqrt(np.diag(covariance(fit, s)[0])) for s in (found, taken_as_read))
    names = [u.name for u in fit.unknowns]
    assert sorted(found.drives) == [0, 1, 2]
    gain = names.index("gain")
    assert wide[gain] > 1.2 * narrow[gain]
    assert (wide > 0.99 * narrow).all()
    true = {"k": BENCH.k, "c1": BENCH.c1, "gain": GAIN}
    for name, value in true.items():
        assert abs(fit.values.get(name) - value) < 3.5 * wide[names.index(name)]


def test_a_drive_that_is_late_is_not_wrong_by_its_noise():
    setting, baseline = fitted(campaign(late=8e-3))
    found, fit = with_drives_of_angles(setting, baseline)
    assert found is setting
    assert fit is baseline


def test_a_commanded_drive_has_no_readings_to_be_wrong():
    setting, baseline = fitted(campaign(measured=False))
    assert with_drives_of_angles(setting, baseline) == (setting, baseline)


@pytest.mark.parametrize("omega", OMEGAS)
def test_errors_are_those_of_least_squares(omega):
    """Of two hundred readings of one drive, the true one is as far off as four normal numbers."""
    t = np.arange(400) / RATE
    true = BENCH.A * np.sin(omega * t + 0.4)
    rng = np.random.default_rng(3)
    run = campaign().recordings[0]
    off = []
    for _ in range(200):
        read = true + DRIVE_NOISE * BENCH.A * rng.standard_normal(t.size)
        drive = periodic(dataclasses.replace(run, t=t, phi1=t, phi2=t, drive=read))
        z = np.linalg.lstsq(drive.errors, true - drive.values)[0]
        np.testing.assert_allclose(drive.moved(z).values, true, atol=1e-4 * BENCH.A)
        off.append(z @ z)
    assert np.mean(off) == pytest.approx(4.0, rel=0.15)


def test_errors_of_rounding_do_not_fall_with_every_period():
    """Coarse readings with hardly any noise; of the true drive they are off by a few at most."""
    rng = np.random.default_rng(5)
    run = campaign().recordings[0]
    t = np.arange(8000) / RATE
    off = []
    for size in np.linspace(2.0, 8.0, 20):
        true = size * np.sin(OMEGAS[1] * t + size)
        drive = periodic(
            dataclasses.replace(
                run, t=t, phi1=t, phi2=t, drive=np.round(true + 0.05 * rng.standard_normal(t.size))
            )
        )
        z = np.linalg.lstsq(drive.errors, true - drive.values)[0]
        off.append(float(z @ z) / z.size)
    assert np.median(off) < 1.5
    assert max(off) < 4.0


def test_noise_of_the_drive_of_a_run_held_out_is_no_error_of_the_model():
    runs = campaign()
    held = [dataclasses.replace(r, held_out=i == 0) for i, r in enumerate(runs.recordings)]
    setting, fit = with_drives_of_angles(*fitted(dataclasses.replace(runs, recordings=tuple(held))))
    horizon = fit.problem.windows.horizon
    found = evaluate(setting, fit.values, horizon)
    assert sorted(found.setting.drives) == [0, 1, 2]
    before, after = (
        abs(phase(s.recordings[0].t, s.recordings[0].drive, OMEGAS[0]))
        for s in (setting, found.setting)
    )
    assert after < 0.3 * before
    as_read = squares(fit_from_readings(setting.problem(horizon, [0]), fit.values, eps=setting.eps))
    assert as_read.mean_square() > (1.3 * NOISE) ** 2
    assert found.mean_square() < (1.05 * NOISE) ** 2
