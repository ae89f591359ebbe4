"""Indices of an output whose variance is known, then of the pendulum."""

import numpy as np
import pytest

from tests.reference import BENCH
from tp_jax.identifiability.design import UNKNOWNS, sine_design
from tp_jax.sensitivity_analysis import morris as morris_module
from tp_jax.sensitivity_analysis import sobol as sobol_module
from tp_jax.sensitivity_analysis.morris import morris
from tp_jax.sensitivity_analysis.ranges import Range, ranges
from tp_jax.sensitivity_analysis.sobol import sobol

TS = np.linspace(0.0, 1.0, 11)
THREE = tuple(Range(n, 0.0, 1.0, False) for n in ("a", "b", "c"))
DESIGN = sine_design(13.09, TS)


def product(design, values, varied):
    """t (a + 2 b) in one channel, (a - 1/2) (b - 1/2) in the other; c does nothing."""
    a, b = varied["a"], varied["b"]
    one = np.outer(a + 2.0 * b, design.ts)
    two = np.outer((a - 0.5) * (b - 0.5), np.ones_like(design.ts))
    return {"phi1": one, "phi2": two}


def test_sobol_of_a_sum_and_of_a_product(monkeypatch):
    monkeypatch.setattr(sobol_module, "motions", product)
    found = sobol(DESIGN, {}, THREE, samples=1024, seed=0)
    np.testing.assert_allclose(found.first_whole["phi1"], [0.2, 0.8, 0.0], atol=0.02)
    np.testing.assert_allclose(found.total_whole["phi1"], [0.2, 0.8, 0.0], atol=0.02)
    # a product of centred factors has no part of either alone
    np.testing.assert_allclose(found.first_whole["phi2"], [0.0, 0.0, 0.0], atol=0.05)
    np.testing.assert_allclose(found.total_whole["phi2"], [1.0, 1.0, 0.0], atol=0.05)
    assert np.isnan(found.first["phi1"][0]).all()  # nothing varies at t = 0
    assert (found.total_error["phi1"] < 0.2).all()
    assert found.runs == 1024 * 5


def test_morris_of_a_sum(monkeypatch):
    monkeypatch.setattr(morris_module, "motions", product)
    found = morris(DESIGN, {}, THREE, trajectories=40, seed=0)
    np.testing.assert_allclose(found.mu_star["phi1"][-1], [1.0, 2.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(found.sigma["phi1"][-1], 0.0, atol=1e-9)
    assert found.sigma["phi2"][-1][0] > 0.1  # it depends on the other
    assert found.runs == 40 * 4


@pytest.fixture(scope="module")
def bench():
    values = {n: BENCH.get(n, 0.0) for n in UNKNOWNS}
    names = [n for n in UNKNOWNS if n != "B1"]
    design = sine_design(13.09, np.linspace(0.0, 2.0, 101))
    over = ranges(values, names, values["B1"])
    return (
        sobol(design, values, over, samples=32, times=11),
        morris(design, values, over, trajectories=8, times=11),
    )


def test_ts2_has_no_influence_at_all(bench):
    variance, effects = bench
    i = variance.names.index("Ts2")
    for channel in ("phi1", "phi2"):
        assert variance.total_whole[channel][i] == 0.0
        assert effects.mu_star_whole[channel][i] == 0.0


def test_spring_and_drive_outweigh_t0(bench):
    variance, effects = bench
    place = variance.names.index
    for channel in ("phi1", "phi2"):
        assert variance.total_whole[channel][place("T0")] < 0.01
        for big in ("k", "A"):
            assert variance.total_whole[channel][place(big)] > 0.05
            ours = effects.mu_star_whole[channel]
            assert ours[place(big)] > 20.0 * ours[place("T0")]


def test_the_same_seed_gives_the_same(bench):
    values = {n: BENCH.get(n, 0.0) for n in UNKNOWNS}
    design = sine_design(13.09, np.linspace(0.0, 2.0, 101))
    over = ranges(values, [n for n in UNKNOWNS if n != "B1"], values["B1"])
    again = sobol(design, values, over, samples=32, times=11)
    np.testing.assert_array_equal(again.total_error["phi2"], bench[0].total_error["phi2"])
