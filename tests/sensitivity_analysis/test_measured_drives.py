"""The gain of a measured drive is varied about the mean of its reading."""

import equinox as eqx
import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import tp_jax as tp
from tp_jax.identifiability.design import Design, sine_design
from tp_jax.identifiability.log_derivatives import log_derivatives
from tp_jax.model.drive import PiecewiseCubicDrive
from tp_jax.sensitivity_analysis.measured_drives import about_the_mean

TS = np.linspace(0.0, 2.0, 101)
BENCH = tp.presets.values("bench")
GAIN = 0.18


def of_a_reading(zero: float) -> Design:
    """The bench, whose motor's angle is read with a zero that the fit knows as its level."""
    t = np.linspace(0.0, 2.0, 501)
    pieces = CubicSpline(t, zero + np.sin(2.0 * np.pi * t)).c

    def build(p):
        drive = PiecewiseCubicDrive(p["gain"], -GAIN * zero, t, pieces)
        return eqx.tree_at(lambda m: m.drive, tp.presets.double_pendulum(**BENCH), drive)

    return Design("run", TS, np.zeros(4), build, ("k", "gain"), np.full(2, 1e-3))


def by_gain(design: Design) -> np.ndarray:
    return log_derivatives(design, {"gain": GAIN}, ["gain"]).phi1[:, 0]


def test_the_zero_of_the_reading_does_not_matter():
    plain, turned = of_a_reading(0.0), of_a_reading(2.57)
    at_the_fit = [tp.simulate(d.build({"gain": GAIN}), TS).phi1 for d in (plain, turned)]
    np.testing.assert_allclose(*at_the_fit, atol=1e-9)
    assert np.ptp(by_gain(turned)) > 1.5 * np.ptp(by_gain(about_the_mean(turned, GAIN)))
    np.testing.assert_allclose(
        by_gain(about_the_mean(turned, GAIN)), by_gain(about_the_mean(plain, GAIN)), atol=1e-6
    )
    motion = tp.simulate(about_the_mean(turned, GAIN).build({"gain": GAIN}), TS)
    np.testing.assert_allclose(motion.phi1, at_the_fit[1], atol=1e-9)


def test_a_sine_stays_as_it_is():
    design = sine_design(13.0, TS)
    assert about_the_mean(design, 1.0) is design


def test_the_mean_is_that_of_what_is_looked_at():
    turned = about_the_mean(of_a_reading(2.57), GAIN).build({"gain": GAIN})
    assert float(turned.drive.offset) == pytest.approx(0.0, abs=1e-3)
