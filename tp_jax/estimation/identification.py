"""Result of `identify`, as plain numbers and in words."""

import dataclasses
from collections.abc import Sequence

import numpy as np

from tp_jax._digits import digits_of
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.multistart import Trial
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.model.parameters import BASE
from tp_jax.results.identification import (
    IdentificationRecord,
    StartRecord,
    SuccessRecord,
    Warned,
)
from tp_jax.results.sizes import Size


@dataclasses.dataclass(frozen=True, kw_only=True)
class Identification(IdentificationRecord):
    """Result of `identify`; `to_dict` gives it as plain numbers, schema tp-jax/identify/1.

    fit: the best, at the longest horizon. trials: all starts, in order. Neither is in `to_dict`.
    """

    fit: Fit = dataclasses.field(compare=False, metadata={"key": None})
    trials: tuple[Trial, ...] = dataclasses.field(default=(), compare=False, metadata={"key": None})

    def __repr__(self) -> str:
        told = ", ".join(f"{name}={value:.4g}" for name, value in self.parameters.items())
        return f"Identification({self.campaign!r} by {self.method}: {told})"

    @property
    def parameters(self) -> dict[str, float]:
        """Value of each parameter by name [SI units]."""
        return {name: _value(size) for name, size in self.sizes.items()}

    def summary(self) -> str:
        """A table for a terminal."""
        lines = [
            f"{self.campaign}: {self.model} model, {self.method}, chi2/dof {self.chi2_dof:.4g}"
        ]
        lines.append(f"{'':8}{'value':>12}  {'95 % interval':<26} unit")
        for name, p in self.sizes.items():
            value, (low, high) = _value(p), p.ci95 or (None, None)
            digits, span = 5, "fixed" if p.ci95 is None else "at its bound"
            if low is not None and high is not None:
                digits = max(digits_of(value, low, high), 4)
                span = f"{low:.{digits}g} to {high:.{digits}g}"
            mark = "" if p.identifiable else "  not identifiable"
            lines.append(f"{name:8}{value:12.{digits}g}  {span:<26} {p.unit}{mark}")
        lines.append(told(self.success, self.starts))
        lines += [f"Warning: {w.text}" for w in self.warnings]
        return "\n".join(lines)


def _value(size: Size) -> float:
    assert isinstance(size.value, float | int)  # a parameter has one value
    return size.value


def told(success: SuccessRecord, starts: Sequence[StartRecord]) -> str:
    """Says how many starts succeeded, and at what cost."""
    if success.of == 1:
        return f"One start, {starts[0].evaluations} passes over the data."
    low, high = success.ci95 or (None, None)
    text = f"{success.reached} of {success.of} starts reached the best"
    if low is not None and high is not None:
        text += f" (95 %: {100 * low:.0f} to {100 * high:.0f} %)"
    cost = success.expected_evaluations
    if cost is not None:
        text += f"; {cost:.0f} passes over the data are expected until one does"
    failed = sum(start.objective is None for start in starts)
    if failed:
        text += f"; {failed} could not be integrated"
    return text + "."


def parameter_table(found: dict[str, dict], setting: PreparedCampaign) -> dict[str, Size]:
    """Every parameter: value, unit, ci95, whether the data identify it; found: see `intervals`."""
    sizes = {
        n: Size(e["value"], e["unit"], e["ci95"] and tuple(e["ci95"]), e["identifiable"])
        for n, e in found.items()
    }
    out = {}
    for p in BASE:
        if p.name in sizes:
            out[p.name] = sizes[p.name]
        elif p.name in setting.fixed:
            out[p.name] = Size(setting.fixed[p.name], p.unit, None, True)
        elif p.name == "Ts2" and setting.rider:
            out["Ts2"] = Size(0.0, p.unit, None, False)
    return {**out, **sizes}


def warnings(fit: Fit, setting: PreparedCampaign, entries: dict[str, dict]) -> list[Warned]:
    """Lists what a user must know before using the numbers; entries: see `intervals`."""
    found = []
    torques = [p.name for p in BASE if p.per_inertia]
    if setting.campaign.B1 is None and "B1" not in setting.fixed:
        found.append(_free_scale(torques, "B1 is not given, so that B1 = 1 was taken"))
    elif setting.campaign.B1 is None or setting.model == "paper":
        text = f"the scale rests on B1 = {setting.fixed['B1']:g} kg m^2 alone"
        found.append(_free_scale(torques, text))
    if setting.rider:
        text = (
            "Ts2 acts only where the rider's velocity is exactly zero, so that it has no effect "
            "on any motion; it is held at 0."
        )
        found.append(_warning("unidentifiable", ["Ts2"], text))
    base = {p.name for p in BASE}
    bound = [u.name for u, b in zip(fit.unknowns, fit.at_bound, strict=True) if b]
    # Where only the user's own bound stands in the way, the recordings may well tell the number.
    stopped = [n for n in bound if n in setting.bounds]
    loose = [
        n for n, e in entries.items() if not e["identifiable"] and n in base and n not in stopped
    ]
    if loose:
        text = f"These recordings do not tell {', '.join(loose)}."
        found.append(_warning("unidentifiable", loose, text))
    if bound:
        text = f"At a bound: {', '.join(bound)}."
        if stopped:
            text += (
                f" The fit would take {', '.join(stopped)} beyond the bounds that were given; "
                "widen them unless they are known to hold."
            )
        found.append(_warning("at_bound", bound, text))
    for held in dict.fromkeys(e["ridge"] for e in entries.values() if "ridge" in e):
        partners = [n for n, e in entries.items() if e.get("ridge") == held and n != held]
        low, high = entries[held]["ci95"]
        text = f"{held} may be anything from {low:.4g} to {high:.4g}"
        if partners:
            text += f"; {', '.join(partners)} make up for it, and their intervals hold all of that"
        found.append(_warning("ridge", [held, *partners], f"{text}."))
    if fit.chi2_dof > 1.2:
        text = (
            f"The misfit is {fit.chi2_dof**0.5:.3g} times the noise: the model lacks something; "
            "run `tp-jax diagnose`."
        )
        found.append(_warning("misfit", [], text))
    if not fit.converged:
        found.append(_warning("not_converged", [], fit.message))
    return found


def start_warnings(trials: Sequence[Trial], reached: Sequence[bool]) -> list[Warned]:
    """Warns of what the starts say about the answer."""
    failed = [t for t in trials if not np.isfinite(t.end.cost)]
    found = []
    if failed:
        text = f"{len(failed)} of {len(trials)} starts came to nothing: {failed[0].end.message}"
        found.append(_warning("failed_starts", [], text))
    if len(trials) >= 4 and sum(reached) == 1:
        text = (
            f"Only one of {len(trials)} starts ended in the best optimum: there may be a better "
            "one; try more starts."
        )
        found.append(_warning("best_found_once", [], text))
    return found


def _warning(code: str, parameters: list[str], text: str) -> Warned:
    return Warned(code=code, parameters=tuple(parameters), text=text)


def _free_scale(torques: list[str], reason: str) -> Warned:
    text = (
        f"No torque is measured and {reason}: {', '.join(torques)} are known only relative to B1."
    )
    return _warning("free_scale", torques, text)
