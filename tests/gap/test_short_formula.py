"""A short formula in the place of a curve."""

import numpy as np
import pytest

from tp_jax.gap.short_formula import short_formula

X = np.linspace(-0.7, 0.8, 101)
SPEED = np.linspace(0.0, 5.0, 101)
BAND = np.full(X.size, 0.01)


@pytest.mark.parametrize(
    ("x", "y", "sided", "formula"),
    [
        (X, 0.6 * np.cos(3.0 * X), False, "0.6 cos 3 φ1"),
        (X, 0.1 - 0.4 * X**3, False, "−0.4 φ1³"),
        (X, 0.2 * np.abs(X) + 7.0, False, "0.2 |φ1|"),
        (SPEED, 0.3 * np.exp(-SPEED / 0.5), True, "0.3 exp(−φ1/0.5)"),
        (SPEED, 0.02 * SPEED**2, True, "0.02 φ1²"),
    ],
)
def test_is_recognised(x, y, sided, formula):
    found = short_formula(x, y, 1e-3 * BAND, "φ1", sided)
    assert found is not None
    assert found.startswith(formula)


def test_the_band_decides():
    y = 0.3 * X**2 + 0.05 * np.sin(20.0 * X)
    assert short_formula(X, y, BAND, "φ1") is None
    assert short_formula(X, y, 6.0 * BAND, "φ1") is not None


def test_signs_stand_between_the_terms():
    found = short_formula(X, 0.3 * np.cos(2.0 * X) - 0.2 * np.sin(2.0 * X), 1e-3 * BAND, "φ1")
    assert found == "0.3 cos 2 φ1 − 0.2 sin 2 φ1"
