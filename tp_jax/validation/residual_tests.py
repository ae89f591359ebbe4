"""Are the residuals noise? Whiteness, and against time, angle and velocity.

Every statistic is rescaled by what it is on average for white noise after the same fit (a Bartlett
correction by simulation), then compared with its usual distribution; p-values are adjusted for
their number after Holm.
"""

import dataclasses
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy import stats

from tp_jax.estimation.baseline import Setting
from tp_jax.estimation.least_squares import Fit
from tp_jax.validation import analysis_of_variance, breusch_pagan, ljung_box, runs
from tp_jax.validation.null import DRAWS, null_residuals
from tp_jax.validation.series import Series, series

LEVEL = 0.05
AGAINST = ("time", "angle", "velocity")


class Row(NamedTuple):
    """One test of one series.

    test: "ljung_box", "runs", "breusch_pagan" (spread) or "analysis_of_variance" (mean); against:
    "time", "angle", "velocity" or None; statistic: corrected; p: its p-value; p_adjusted: for the
    number of tests; rejected: whether that is below 5 %.
    """

    recording: str
    channel: str
    test: str
    against: str | None
    statistic: float
    p: float
    p_adjusted: float
    rejected: bool


@dataclasses.dataclass(frozen=True)
class ResidualTests:
    """What `residual_tests` found: a row for each test."""

    rows: tuple[Row, ...]

    @property
    def rejected(self) -> tuple[Row, ...]:
        """Those that reject noise, the clearest first."""
        return tuple(sorted((r for r in self.rows if r.rejected), key=lambda r: r.p))

    def to_dict(self) -> dict[str, Any]:
        """As plain numbers."""
        return {
            "level": LEVEL,
            "rejected": len(self.rejected),
            "of": len(self.rows),
            "tests": [r._asdict() for r in self.rows],
        }


def residual_tests(
    fit: Fit, setting: Setting, *, draws: int = DRAWS, seed: int = 0
) -> ResidualTests:
    """Tests whether the residuals of a windowed fit are white noise.

    Args:
        fit: the fit.
        setting: its campaign.
        draws: of the noise by which statistics are corrected.
        seed: of that noise.
    """
    from statsmodels.stats.multitest import multipletests

    noise = null_residuals(fit, draws, seed)
    found = [row for one in series(fit, setting) for row in _tests(one, noise)]
    if not found:
        return ResidualTests(())
    rejected, adjusted, *_ = multipletests([row[-1] for row in found], LEVEL, "holm")
    return ResidualTests(
        tuple(
            Row(*row, float(p), bool(r))
            for row, p, r in zip(found, adjusted, rejected, strict=True)
        )
    )


def _tests(s: Series, noise: np.ndarray) -> list[tuple]:
    """Recording, channel, test, against, statistic and p of one series."""
    draws = noise[:, s.window, s.row]
    n = s.residual.size
    values = {"time": s.t, "angle": s.angle, "velocity": s.velocity}
    if n < 20:
        return []
    out = []

    def chi_square(test: str, against: str | None, of: Callable, degrees: int) -> None:
        ours, usual = of(s.residual), np.mean([of(d) for d in draws])
        corrected = ours * degrees / usual if usual > 0.0 else 0.0
        p = float(stats.chi2.sf(corrected, degrees))
        out.append((s.recording, s.channel, test, against, float(corrected), p))

    chi_square("ljung_box", None, ljung_box.statistic, ljung_box.lags(n))
    z = [runs.statistic(d) for d in draws]
    standard = float((runs.statistic(s.residual) - np.mean(z)) / max(np.std(z, ddof=1), 1e-9))
    out.append(
        (s.recording, s.channel, "runs", None, standard, float(2 * stats.norm.sf(abs(standard))))
    )
    for name in AGAINST:
        x = values[name]
        if not np.ptp(x) > 0.0:
            continue
        chi_square(
            "analysis_of_variance", name, lambda r, x=x: analysis_of_variance.statistic(r, x),
            analysis_of_variance.cells(n) - 1,
        )  # fmt: skip
        chi_square(
            "breusch_pagan", name, lambda r, x=x: breusch_pagan.statistic(r, x),
            breusch_pagan.DEGREES,
        )  # fmt: skip
    return out
