"""Confirmation of a cause by the prediction of motions unlike those fitted.

Both models, with the cause and without, predict groups that neither was fitted to (`left_out`). A
cause is confirmed where the sum of squares falls by more than a search among many effects finds by
chance, where what some groups gain is not lost by others, and where over long windows the error
does not grow. Sums of squares are divided by the misfit of the better model: one that is wrong
everywhere is not certain of details.
"""

import dataclasses

import numpy as np

from tp_jax.gap.left_out import LeftOut
from tp_jax.gap.policy import ConfirmPolicy


@dataclasses.dataclass(frozen=True)
class Confirmation:
    """Result of predicting left-out groups with a cause and without.

    Attributes:
        confirmed: whether it is.
        deviance: fall of the left-out sum of squares over the misfit.
        lost: what groups lose of what others gain.
        error_ratio: root mean square error over long windows, with the cause over without; NaN
            where the sums of squares refuse it already.
        reason: why not, in a clause; "" if confirmed.
    """

    confirmed: bool
    deviance: float
    lost: float
    error_ratio: float
    reason: str


def confirm(
    without: LeftOut, with_cause: LeftOut, misfit: float, amplitudes: int, policy: ConfirmPolicy
) -> Confirmation:
    """Judges a cause by what it does to groups that were left out.

    Args:
        without, with_cause: errors of both models on the same groups.
        misfit: chi^2/dof of the fit with the cause, 1 at least.
        amplitudes: of the cause.
        policy: thresholds.
    """
    fall = _falls(without.short, with_cause.short) / max(misfit, 1.0)
    gained = float(fall[fall > 0.0].sum())
    lost = float(-fall[fall < 0.0].sum())
    deviance = gained - lost
    needed = policy.deviance + policy.per_amplitude * amplitudes
    reason, ratio = "", np.nan
    if not deviance > needed:
        reason = "the prediction of recordings left out does not improve beyond chance"
    elif lost > policy.worse * gained:
        reason = "some recordings left out are predicted better and others worse"
    else:
        ratio = _ratio(without.long, with_cause.long)
        if not ratio <= policy.harm:
            reason = "the prediction of long runs left out gets worse"
    part = lost / gained if gained > 0.0 else np.inf
    return Confirmation(not reason, deviance, part, ratio, reason)


def _falls(without: np.ndarray, with_cause: np.ndarray) -> np.ndarray:
    """Falls of the groups' sums of squares.

    A group through which only the model with the cause cannot be integrated is lost without limit.
    One that the other model cannot follow says nothing of a size: it counts as nothing.
    """
    known = np.isfinite(without) & np.isfinite(with_cause)
    falls = np.zeros_like(without)
    falls[known] = without[known] - with_cause[known]
    falls[np.isfinite(without) & ~np.isfinite(with_cause)] = -np.inf
    return falls


def _ratio(without: np.ndarray, with_cause: np.ndarray) -> float:
    """Computes a ratio of rms over the groups; infinite where only the model without is at hand."""
    if not np.isfinite(with_cause[np.isfinite(without)]).all():
        return np.inf
    both = np.isfinite(without) & np.isfinite(with_cause)
    if not both.any():
        return 1.0
    return float(np.sqrt(with_cause[both].mean() / max(without[both].mean(), 1e-300)))
