"""Residuals of a right model pass, those of a wrong one do not."""

import numpy as np

from tp_jax.validation import residual_tests
from tp_jax.validation.null import null_residuals
from tp_jax.validation.series import series


def test_series_hold_every_sample_once(right):
    setting, fit = right
    found = series(fit, setting)
    assert [(s.recording, s.channel) for s in found][:2] == [
        ("decay.csv", "phi1"), ("decay.csv", "phi2"),
    ]  # fmt: skip
    assert len(found) == 6
    for s in found:
        assert (np.diff(s.t) > 0.0).all()
        assert s.t.size == 501
    total = sum(float((s.residual**2).sum()) for s in found)
    assert np.isclose(total, (fit.linearisation.r[:, :-4] ** 2).sum())


def test_noise_after_a_fit_has_four_directions_less_in_each_window(right):
    _, fit = right
    noise = null_residuals(fit, draws=200, seed=0)
    assert noise.shape == (200, *fit.linearisation.r.shape)
    samples = fit.linearisation.valid[:, :-4].sum(axis=1)
    left = (noise[:, :, :-4] ** 2).sum(axis=2).mean(axis=0)
    # priors hold a part of what the states would take
    error = np.sqrt(2.0 * samples.mean() / 200 / samples.size)
    assert -4.0 - 3.0 * error < (left - samples).mean() < -1.0 + 3.0 * error
    # what was taken out is gone
    along = np.einsum("wmx,bwm->bwx", fit.linearisation.states_jac, noise)
    size = np.linalg.norm(fit.linearisation.states_jac, axis=1)
    assert np.abs(along / size).max() < 1e-8


def test_a_right_model_passes(right):
    setting, fit = right
    found = residual_tests(fit, setting)
    assert len(found.rows) == 6 * 8
    assert len(found.rejected) <= 1
    # p-values of tests that hold are spread evenly
    assert 0.3 < np.mean([r.p for r in found.rows]) < 0.7


def test_a_wrong_one_does_not(wrong):
    setting, fit = wrong
    found = residual_tests(fit, setting)
    assert {r.test for r in found.rejected} >= {"ljung_box", "runs", "analysis_of_variance"}
    assert found.to_dict()["rejected"] == len(found.rejected)
    assert all(r.p <= r.p_adjusted for r in found.rows)


def test_the_same_seed_gives_the_same(right):
    setting, fit = right
    assert residual_tests(fit, setting, draws=5) == residual_tests(fit, setting, draws=5)
