"""Each statistic on numbers whose nature is known."""

import numpy as np
import pytest
from scipy import stats

from tp_jax.validation import analysis_of_variance, breusch_pagan, ljung_box, runs

N = 1500


@pytest.fixture
def white(rng):
    return rng.standard_normal(N)


@pytest.fixture
def coloured(rng):
    e = rng.standard_normal(N)
    out = np.empty(N)
    last = 0.0
    for i in range(N):
        last = out[i] = 0.3 * last + e[i]
    return out


def test_ljung_box(white, coloured):
    k = ljung_box.lags(N)
    assert k == 20
    assert stats.chi2.sf(ljung_box.statistic(white), k) > 0.01
    assert stats.chi2.sf(ljung_box.statistic(coloured), k) < 1e-6


def test_ljung_box_of_few(rng):
    few = rng.standard_normal(30)
    assert ljung_box.lags(few.size) == 6
    assert np.isfinite(ljung_box.statistic(few))


def test_runs(white, coloured):
    assert abs(runs.statistic(white)) < 3.0
    assert runs.statistic(coloured) < -4.0  # too few
    assert runs.statistic(np.tile([1.0, -1.0], 100)) > 4.0  # too many


def test_runs_of_one_sign():
    assert runs.statistic(np.ones(100)) == -10.0


def test_breusch_pagan(white, rng):
    x = rng.uniform(-2.0, 2.0, N)
    assert stats.chi2.sf(breusch_pagan.statistic(white, x), 2) > 0.01
    assert stats.chi2.sf(breusch_pagan.statistic(white * (1.0 + 0.3 * x**2), x), 2) < 1e-6
    assert breusch_pagan.statistic(white, np.ones(N)) == 0.0


def test_breusch_pagan_against_two_values_only(white):
    assert breusch_pagan.statistic(white, np.tile([0.0, 1.0], N // 2)) == 0.0


def test_analysis_of_variance(white, rng):
    x = rng.uniform(-2.0, 2.0, N)
    degrees = analysis_of_variance.cells(N) - 1
    assert stats.chi2.sf(analysis_of_variance.statistic(white, x), degrees) > 0.01
    bent = white + 0.3 * np.sign(x)
    assert stats.chi2.sf(analysis_of_variance.statistic(bent, x), degrees) < 1e-6
    assert analysis_of_variance.statistic(white, np.zeros(N)) == 0.0


def test_levels_are_kept(rng):
    """Of white noise, each test rejects about as often as it says."""
    x = rng.uniform(size=300)
    p = []
    for _ in range(200):
        e = rng.standard_normal(300)
        p.append(
            (
                stats.chi2.sf(ljung_box.statistic(e), ljung_box.lags(300)),
                2.0 * stats.norm.sf(abs(runs.statistic(e))),
                stats.chi2.sf(breusch_pagan.statistic(e, x), 2),
                stats.chi2.sf(
                    analysis_of_variance.statistic(e, x), analysis_of_variance.cells(300) - 1
                ),
            )
        )
    rejected = (np.array(p) < 0.05).mean(axis=0)
    assert ((rejected > 0.01) & (rejected < 0.11)).all(), rejected
