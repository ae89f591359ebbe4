"""Derivatives by logarithms, against differences of runs."""

import numpy as np
import pytest

from tests.reference import BENCH
from tp_jax.identifiability.design import UNKNOWNS, sine_design
from tp_jax.identifiability.log_derivatives import log_derivatives
from tp_jax.simulation.solve import simulate

TS = np.linspace(0.0, 0.6, 61)
DESIGN = sine_design(13.09, TS, noise=2e-3)
VALUES = {n: BENCH.get(n, 0.0) for n in UNKNOWNS}


@pytest.fixture(scope="module")
def found():
    return log_derivatives(DESIGN, VALUES, UNKNOWNS, {**VALUES, "Ts2": 0.01})


@pytest.mark.parametrize("name", ["k", "A", "B2", "c1"])
def test_against_differences(found, name):
    part = 1e-4
    runs = [
        simulate(
            DESIGN.build({**VALUES, name: VALUES[name] * (1.0 + s * part)}), TS, tolerance=1e-9
        )
        for s in (1, -1)
    ]
    i = UNKNOWNS.index(name)
    for channel in ("phi1", "phi2"):
        difference = np.subtract(*(np.asarray(getattr(r, channel)) for r in runs)) / (2.0 * part)
        ours = getattr(found, channel)[:, i]
        assert np.abs(ours - difference).max() < 0.02 * np.abs(difference).max(), channel


def test_what_has_no_effect_has_none(found):
    i = UNKNOWNS.index("Ts2")
    assert not found.phi1[:, i].any()
    assert not found.phi2[:, i].any()


def test_rows_are_in_units_of_the_noise(found):
    rows = found.weighted(DESIGN.sigma)
    assert rows.shape == (2 * TS.size, len(UNKNOWNS))
    np.testing.assert_allclose(rows[: TS.size], found.phi1 / 2e-3)
    assert len(found.weighted(np.array([1.0, np.inf]))) == TS.size
