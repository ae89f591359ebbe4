"""Laws that nobody wrote down: their curves, and the one formula that stands for all of them."""

import numpy as np
import pytest
from numpy.polynomial import chebyshev

from tests.effects.test_formulas import instants, pendulum
from tp_jax.effects import AnyLaw, get, laws
from tp_jax.effects.laws import DEGREE, HALF, MIDDLE, NAMES, curve

every_law = pytest.mark.parametrize("law", laws().values(), ids=list(laws()))
RNG = np.random.default_rng(5)
SIZES = (RNG.normal(size=DEGREE) / np.arange(1, DEGREE + 1)).tolist()
RANGE = {MIDDLE: 0.1, HALF: 0.9}
T = np.array([t for t, _ in instants()])
Y = tuple(np.array([y for _, y in instants()]).T)


def numbers(factor: float = 1.0) -> dict[str, float]:
    return {**RANGE, **{n: factor * c for n, c in zip(NAMES, SIZES, strict=True)}}


def test_a_curve_is_a_chebyshev_series_without_a_constant():
    x = np.linspace(-1.5, 1.5, 61)
    expected = chebyshev.chebval(np.clip((x - 0.1) / 0.9, -1.0, 1.0), [0.0, *SIZES])
    np.testing.assert_allclose(curve(x, 0.1, 0.9, SIZES), expected, atol=1e-14)


def told(model) -> np.ndarray:
    """Derivatives and readings at all instants."""
    return np.stack([*model.derivative(T, Y), *model.readings(T, Y)])


BARE = told(pendulum())


@every_law
def test_one_formula_stands_for_all(law):
    own, shared = (
        told(pendulum(law, numbers())),
        told(pendulum(AnyLaw(), numbers() | law.constants)),
    )
    np.testing.assert_allclose(shared, own, rtol=1e-12, atol=1e-14)
    assert np.abs(own - BARE).max() > 1e-3
    np.testing.assert_array_equal(told(pendulum(law, numbers(0.0))), BARE)


@pytest.mark.parametrize("family", ["bearing_dry.phi1", "contact_dry.v2"])
def test_a_friction_never_drives_the_motion(family):
    low = RANGE | dict.fromkeys(NAMES, 0.0) | {"c1": -20.0, "c2": -20.0}
    m = pendulum(laws()[family], low).motion(T, Y)
    assert float((m.bearing * m.v1).min()) >= -1e-12
    assert float((m.contact * m.v2).min()) >= -1e-12


@every_law
def test_is_found_by_its_family(law):
    assert get(law.id) is law
    assert law.remedy
    assert law.by_hand
    assert law.formula
