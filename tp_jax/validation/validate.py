"""Everything that says whether a fit may be believed, and warnings as `identify` gives them."""

import dataclasses
from collections.abc import Callable
from typing import Any

from tp_jax.estimation.baseline import Setting
from tp_jax.estimation.least_squares import Fit
from tp_jax.identifiability.information import Information, information
from tp_jax.identifiability.profile_likelihood import Profile, profiles
from tp_jax.model.parameters import BASE
from tp_jax.validation.consistency import Consistency, consistency
from tp_jax.validation.reduction import Reduction, reduction
from tp_jax.validation.residual_tests import ResidualTests, residual_tests

CORRELATED = 0.95
"""Estimates correlated more closely than this are known only together."""

PROFILED = ("Tst", "T0")
"""Parameters whose likelihood is seldom a parabola."""

Progress = Callable[[str, float | None], None]


@dataclasses.dataclass(frozen=True)
class Validation:
    """What `validate` found: information, profiles, consistency, reduction, residual tests."""

    information: Information
    profiles: tuple[Profile, ...]
    consistency: Consistency
    reduction: Reduction
    residuals: ResidualTests

    def to_dict(self) -> dict[str, Any]:
        """As plain numbers."""
        known = self.information
        return {
            "correlation": {"parameters": list(known.names), "matrix": known.correlation.tolist()},
            "null_directions": [d.to_dict() for d in known.directions],
            "profile": {p.name: p.to_dict() for p in self.profiles},
            "consistency": self.consistency.to_dict(),
            "reduction": self.reduction.to_dict(),
            "residuals": self.residuals.to_dict(),
        }

    @property
    def warnings(self) -> list[dict[str, Any]]:
        """In the form of the `warnings` of tp-jax/identify/1."""
        return [
            *_correlated(self.information),
            *_unknown(self.information),
            *_open(self.profiles),
            *_inconsistent(self.consistency),
            *_too_large(self.reduction),
            *_coloured(self.residuals),
        ]


def validate(fit: Fit, setting: Setting, *, progress: Progress | None = None) -> Validation:
    """Looks at a fit from all sides.

    Args:
        fit: of the baseline's unknowns, in windows.
        setting: its campaign (`tp_jax.estimation.baseline.prepare_campaign`).
        progress: called with a stage's name and the part of it that is done.
    """
    names = [u.name for u in fit.unknowns]
    return Validation(
        information(fit, setting),
        profiles(fit, setting, [n for n in PROFILED if n in names], progress=progress),
        consistency(fit, setting, progress=progress),
        reduction(fit, setting, progress=progress),
        residual_tests(fit, setting),
    )


def _warning(code: str, parameters: list[str], text: str) -> dict[str, Any]:
    return {"code": code, "parameters": parameters, "text": text}


def _correlated(known: Information) -> list[dict[str, Any]]:
    base = {p.name for p in BASE}
    out = []
    for i, a in enumerate(known.names):
        for j, b in enumerate(known.names[:i]):
            r = float(known.correlation[i, j])
            if abs(r) > CORRELATED and {a, b} <= base:
                text = f"{b} and {a} are known only together: their correlation is {r:.3f}."
                out.append(_warning("correlated", [b, a], text))
    return out


def _unknown(known: Information) -> list[dict[str, Any]]:
    return [
        _warning(
            "null_direction", list(d.coefficients),
            f"These recordings leave open, to a factor of two or more: {d.text}.",
        )
        for d in known.directions
    ]  # fmt: skip


def _open(found: tuple[Profile, ...]) -> list[dict[str, Any]]:
    out = []
    for p in found:
        if not p.identifiable:
            side = "below" if p.ci95[0] is None else "above"
            side = "either way" if p.ci95 == (None, None) else side
            text = f"The interval of {p.name} is open ({side}): its likelihood does not end there."
            out.append(_warning("open_interval", [p.name], text))
    return out


def _inconsistent(found: Consistency) -> list[dict[str, Any]]:
    if not found.rejected:
        return []
    which = f", most clearly in {', '.join(found.differing[:3])}" if found.differing else ""
    text = f"The recordings differ in their parameters (p = {found.p:.2g}){which}."
    return [_warning("inconsistent", list(found.differing), text)]


def _too_large(found: Reduction) -> list[dict[str, Any]]:
    if not found.without:
        return []
    names = ", ".join(found.without)
    text = f"The recordings do not reject a smaller baseline, without {names}."
    return [_warning("smaller_baseline", list(found.without), text)]


def _coloured(found: ResidualTests) -> list[dict[str, Any]]:
    if not found.rejected:
        return []
    first = found.rejected[0]
    against = f" against {first.against}" if first.against else ""
    text = (
        f"{len(found.rejected)} of {len(found.rows)} tests reject that the residuals are noise, "
        f"most clearly {first.test}{against} for {first.channel} of {first.recording}."
    )
    return [_warning("residuals", [], text)]
