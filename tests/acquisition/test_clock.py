"""The skew of the rig's clock out of delays that are never negative."""

import numpy as np
import pytest

from tp_jax.acquisition.clock import LEAST_POINTS, fit_clock
from tp_jax.acquisition.recorder import correction

SPAN = 60.0


def delays(kind, true, rng):
    """Delays [s] of samples taken at true times [s]."""
    delay = 50e-6 + rng.exponential(100e-6, true.size)
    if kind == "stalls":  # a host that is busy at one read in five
        busy = rng.random(true.size) < 0.2
        delay[busy] += rng.exponential(0.02, int(busy.sum()))
    elif kind == "load":  # that has more to do in the second half
        delay = delay + 1e-4 * (true > SPAN / 2)
    elif kind == "usb":  # a bus asked every millisecond, 80 ppm off the rig's clock
        period = 1.00008e-3
        delay = np.ceil((true + delay) / period) * period - true + rng.exponential(3e-5, true.size)
    elif kind == "batches":  # an adapter that hands over every 16 ms
        delay = np.ceil((true + delay) / 0.0161) * 0.0161 - true
    return delay


@pytest.mark.parametrize("kind", ["quiet", "stalls", "load", "usb", "batches"])
@pytest.mark.parametrize("skew", [200e-6, -200e-6, 0.0])
def test_a_skew_is_found_within_10_ppm(kind, skew):
    rng = np.random.default_rng(3)
    for _ in range(5):
        true = np.sort(rng.integers(0, 1000 * int(SPAN), 3000)) / 1000 / (1.0 + skew)
        fit = fit_clock(true * (1.0 + skew), 5e4 + true + delays(kind, true, rng), poll=1e-3)
        assert abs(fit.skew - skew) < 10e-6
        assert abs(fit.skew - skew) < 3.0 * fit.skew_error
        assert fit.skew_error < 20e-6
        assert 5e4 - 3.0 * fit.offset_error < fit.offset < 5e4 + 2e-3
        assert fit.points == 3000


@pytest.mark.parametrize("where", [0.15, 0.55, 0.7, 0.9])
@pytest.mark.parametrize("jump", [-0.02, 0.02, 1.0, -5.0])
def test_a_clock_that_jumps_has_no_skew(where, jump):
    """A computer that sleeps while the rig goes on, for one."""
    rng = np.random.default_rng(0)
    rig = np.arange(0.0, SPAN, 0.03)
    late = rng.exponential(1e-3, rig.size)
    assert correction(fit_clock(rig, rig + late + jump * (rig > where * SPAN))) == 1.0
    skew = fit_clock(rig, rig / 1.001 + late)
    assert correction(skew) == pytest.approx(1.0 / 1.001, abs=2e-5)


def test_exact_clocks():
    d = np.arange(0.0, 10.0, 0.01)
    fit = fit_clock(d, 7.0 + d / 1.0003)
    assert fit.skew == pytest.approx(3e-4, abs=1e-12)
    assert fit.offset == pytest.approx(7.0, abs=1e-9)
    assert fit.delay == pytest.approx(0.0, abs=1e-9)


def test_where_there_is_nothing_to_say():
    assert fit_clock([], []) is None
    d = np.linspace(0.0, 100.0, LEAST_POINTS - 1)
    assert fit_clock(d, d) is None
    d = np.linspace(0.0, 0.5, 1000)
    assert fit_clock(d, d) is None
