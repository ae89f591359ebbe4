"""The curve of a learned law, as a diagnosis reports it: values, a band, where motion went."""

import numpy as np

from tp_jax import _tails as tails
from tp_jax.effects import Law
from tp_jax.effects.base import FROZEN
from tp_jax.effects.laws import DEGREE, HALF, MIDDLE, curve
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.intervals import covariance
from tp_jax.estimation.layout import Unknown
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.gap.directions import Variant
from tp_jax.gap.short_formula import short_formula
from tp_jax.gap.visited import visited
from tp_jax.results.diagnosis import Curve, Visited

POINTS = 101
"""Points of the curve: its polynomials turn twelve times."""

BINS = 40
"""Bins of the histogram of visited values."""


def curve_of(setting: PreparedCampaign, fit: Fit, variant: Variant) -> tuple[Curve, str | None]:
    """A law's curve over what the fitted recordings visited.

    Args:
        setting, fit: the campaign, and a fit with the law. variant: the law, with its range.

    Returns:
        The curve with its band, and a short formula that says the same within the band, or None. y
        is what the law adds to the model without it: to a friction a part of its mean, to the
        spring what is not linear, else what is not constant.
    """
    law = variant.effect
    assert isinstance(law, Law)
    shapes = dict(variant.shapes)
    middle, half = shapes[MIDDLE], shapes[HALF]
    samples = visited(setting, fit)[law.id]
    samples = np.clip(samples, middle - half, middle + half)
    x = np.linspace(samples.min(), samples.max(), POINTS)
    names = [law.qualified(a.name) for a in law.amplitudes]
    every, dof = covariance(fit, setting)
    mine = [fit.unknowns.index(Unknown(n)) for n in names]
    c = np.array([fit.values.get(n) for n in names])
    at_x, at_samples = _basis(x, middle, half), _basis(samples, middle, half)
    # A constant is the friction's own parameter, and a line the spring's stiffness and zero.
    linear = law.place.location == "spring"
    trend = np.stack([np.ones_like(samples), samples * linear], axis=1)
    inside = np.linalg.lstsq(trend, at_samples, rcond=None)[0]
    basis = at_x - np.stack([np.ones_like(x), x * linear], axis=1) @ inside
    basis = basis * law.place.size * (fit.problem.B1 if law.place.per_inertia else 1.0)
    level = 1.0
    if law.place.friction:
        level = 1.0 + max(law.place.size * float(inside[0] @ c), FROZEN + 1e-9)
    y = basis @ c / level
    sd = np.sqrt(np.maximum(np.einsum("nk,kl,nl->n", basis, every[np.ix_(mine, mine)], basis), 0.0))
    sd = tails.student_level(0.025, float(np.min(dof[mine]))) * sd / level
    share, edges = np.histogram(samples, bins=BINS, range=(x[0], x[-1]))
    found = Curve(
        argument=law.argument.symbol,
        unit=law.argument.unit,
        x=tuple(x.tolist()),
        y=tuple(y.tolist()),
        y_unit=law.place.unit,
        ci95=tuple(zip((y - sd).tolist(), (y + sd).tolist(), strict=True)),
        visited=Visited(tuple(edges.tolist()), tuple((share / share.sum()).tolist())),
    )
    return found, short_formula(x, y, sd, law.argument.symbol, sided=law.argument.sided)


def _basis(x: np.ndarray, middle: float, half: float) -> np.ndarray:
    """Values (n, k) of the polynomials."""
    return np.stack([np.asarray(curve(x, middle, half, row)) for row in np.eye(DEGREE)], axis=1)
