"""`identify`: the parameters of a campaign, from one or more starts, and which can be trusted."""

import dataclasses
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from scipy import stats

from tp_jax._version import __version__
from tp_jax.errors import InputError
from tp_jax.estimation.baseline import Setting, grow, initial_values, prepare_campaign
from tp_jax.estimation.intervals import intervals
from tp_jax.estimation.layout import Values
from tp_jax.estimation.least_squares import Fit
from tp_jax.estimation.least_squares import fit as fit_windows
from tp_jax.estimation.nelder_mead import free_run_search
from tp_jax.model.parameters import BASE
from tp_jax.recordings import Campaign

SCHEMA = "tp-jax/identify/1"
REACHED = 1.0  # chi-square within which a start counts as having reached the best
SPREAD = np.log(1.5)  # standard deviation of further starts around the data's own, in logarithms

Progress = Callable[[str, float | None], None]


@dataclasses.dataclass(frozen=True)
class Identification:
    """What `identify` found; `to_dict` is the result as plain numbers."""

    result: dict[str, Any]
    fit: Fit

    @property
    def parameters(self) -> dict[str, float]:
        """Value of each parameter by name [SI units]."""
        return {n: p["value"] for n, p in self.result["parameters"].items()}

    def to_dict(self) -> dict[str, Any]:
        """Schema tp-jax/identify/1."""
        return self.result

    def summary(self) -> str:
        """A table for a terminal."""
        r = self.result
        lines = [
            f"{r['campaign']}: {r['model']} model, {r['method']}, chi2/dof {r['chi2_dof']:.4g}"
        ]
        lines.append(f"{'':8}{'value':>12}  {'95 % interval':<26} unit")
        for name, p in r["parameters"].items():
            low, high = p["ci95"] or (None, None)
            span = (
                "fixed"
                if p["ci95"] is None
                else (f"{low:.4g} to {high:.4g}" if high is not None else "at its bound")
            )
            mark = "" if p["identifiable"] else "  not identifiable"
            lines.append(f"{name:8}{p['value']:12.5g}  {span:<26} {p['unit']}{mark}")
        s = r["success"]
        lines.append(f"{s['reached']} of {s['of']} starts reached the best.")
        lines += [f"Warning: {w['text']}" for w in r["warnings"]]
        return "\n".join(lines)


def identify(
    campaign: Campaign,
    *,
    model: str = "newton",
    method: str = "least-squares",
    starts: int = 1,
    fix: Mapping[str, float] | None = None,
    bound: Mapping[str, tuple[float, float]] | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> Identification:
    """Fits the baseline's parameters to the recordings that are not held out.

    Args:
        campaign: see `load_campaign`.
        model: "newton", or "paper" for the equations as printed.
        method: "least-squares" on growing windows, or "nelder-mead" on the free run (17).
        starts: the first is the data's own (see `estimation.start`), the others are drawn around
            it, half as large to twice as large, say.
        fix: parameters to hold, by name, SI units.
        bound: (lower, upper) by name, SI units.
        seed: of the starts.
        progress: called with a stage's name and the part of it that is done.

    Raises:
        InputError: an unknown parameter or method, or bounds in the wrong order.
    """
    begin = time.perf_counter()
    report = progress or (lambda stage, fraction: None)  # noqa: ARG005
    _checked(fix or {}, bound or {}, method, starts)
    setting = prepare_campaign(campaign, model=model, fix=dict(fix or {}), bound=dict(bound or {}))
    base = initial_values(setting)
    rng = np.random.default_rng(seed)
    tried: list[Fit] = []
    records = []
    for i in range(starts):
        start = base if i == 0 else _jittered(setting, base, rng)
        report(f"start {i + 1} of {starts}", i / starts)
        fit, record = _one(setting, start, method, report)
        tried.append(fit)
        records.append(record)
    best = min(tried, key=lambda f: f.cost)
    reached = sum(f.cost - best.cost <= REACHED for f in tried)
    objective = records[tried.index(best)]["objective"]
    low, high = stats.binomtest(reached, starts).proportion_ci(method="wilson")
    result = {
        "schema": SCHEMA,
        "campaign": campaign.name,
        "model": model,
        "method": method,
        "parameters": _parameters(best, setting),
        "objective": objective,
        "chi2_dof": best.chi2_dof,
        "noise_floor": dict(setting.noise),
        "starts": records,
        "success": {"reached": int(reached), "of": starts, "ci95": [float(low), float(high)]},
        "warnings": _warnings(best, setting),
        "provenance": {
            "version": __version__, "seed": seed, "data_sha256": campaign.data_sha256,
            "eps": setting.eps, "horizon_s": best.problem.windows.horizon,
            "wall_s": round(time.perf_counter() - begin, 2),
        },
    }  # fmt: skip
    return Identification(result, best)


def _one(setting: Setting, start: Values, method: str, report: Progress) -> tuple[Fit, dict]:
    """One start to its end. The objective is chi-square of the windows, or y of (17) [rad^2]."""
    if method == "nelder-mead":
        values, y, evaluations, message = free_run_search(setting, start, report)
        problem = setting.problem(setting.horizons[-1])
        # Window states only: what the found numbers are worth, and how well they are known.
        states = fit_windows(problem, values, ()).states
        fit = fit_windows(problem, values, setting.unknowns(), states, max_iterations=0)
        fit.converged = "success" in message.lower()
        return fit, {
            "objective": y if np.isfinite(y) else None, "converged": fit.converged,
            "evaluations": evaluations, "message": message,
        }  # fmt: skip
    fit = grow(setting, start, setting.unknowns())
    return fit, {
        "objective": fit.cost if np.isfinite(fit.cost) else None, "converged": fit.converged,
        "evaluations": fit.evaluations, "message": fit.message,
    }  # fmt: skip


def _checked(fix: Mapping, bound: Mapping, method: str, starts: int) -> None:
    names = [p.name for p in BASE]
    for name in (*fix, *bound):
        if name not in names:
            raise InputError(f"There is no parameter {name!r}, choose one of: {', '.join(names)}.")
    for name, (low, high) in bound.items():
        if not low < high:
            raise InputError(f"The bounds of {name} must rise, but are {low:g} and {high:g}.")
    if method not in ("least-squares", "nelder-mead"):
        raise InputError(f"There is no method {method!r}, choose least-squares or nelder-mead.")
    if starts < 1:
        raise InputError(f"There must be one start or more, but {starts} were asked for.")


def _jittered(setting: Setting, base: Values, rng: np.random.Generator) -> Values:
    changes = {}
    for u in setting.unknowns():
        if u.name in ("phase", "zero1", "level"):
            continue
        changes[u.name] = base.table[base.layout.index[u.name]] * np.exp(SPREAD * rng.normal())
    return base.replace(changes)


def _parameters(fit: Fit, setting: Setting) -> dict[str, dict]:
    found = intervals(fit, setting)
    out = {}
    for p in BASE:
        if p.name in found:
            e = found[p.name]
            out[p.name] = {k: e[k] for k in ("value", "unit", "ci95", "identifiable")}
        elif p.name in setting.fixed:
            out[p.name] = {
                "value": setting.fixed[p.name], "unit": p.unit, "ci95": None, "identifiable": True,
            }  # fmt: skip
        elif p.name == "Ts2" and setting.rider:
            out["Ts2"] = {"value": 0.0, "unit": p.unit, "ci95": None, "identifiable": False}
    for name, e in found.items():
        if name not in out:
            out[name] = {k: e[k] for k in ("value", "unit", "ci95", "identifiable")}
    return out


def _warnings(fit: Fit, setting: Setting) -> list[dict]:
    warnings = []
    torques = [p.name for p in BASE if p.per_inertia]
    if setting.campaign.B1 is None and "B1" not in setting.fixed:
        warnings.append(_free_scale(torques, "B1 is not given, so that B1 = 1 was taken"))
    elif setting.campaign.B1 is None or setting.model == "paper":
        text = f"the scale rests on B1 = {setting.fixed['B1']:g} kg m^2 alone"
        warnings.append(_free_scale(torques, text))
    if setting.rider:
        warnings.append(
            {
                "code": "unidentifiable", "parameters": ["Ts2"],
                "text": "Ts2 acts only where the rider's velocity is exactly zero, so that it has "
                "no effect on any motion; it is held at 0.",
            }
        )  # fmt: skip
    loose = [n for n, e in intervals(fit, setting).items() if not e["identifiable"]]
    loose = [n for n in loose if n in {p.name for p in BASE}]
    if loose:
        warnings.append(
            {
                "code": "unidentifiable", "parameters": loose,
                "text": f"These recordings do not tell {', '.join(loose)}.",
            }
        )  # fmt: skip
    bound = [u.name for u, b in zip(fit.unknowns, fit.at_bound, strict=True) if b]
    if bound:
        warnings.append(
            {"code": "at_bound", "parameters": bound, "text": f"At a bound: {', '.join(bound)}."}
        )
    if fit.chi2_dof > 1.2:
        warnings.append(
            {
                "code": "misfit", "parameters": [],
                "text": f"The misfit is {fit.chi2_dof:.3g} times the noise: the model lacks "
                "something; run `tp-jax diagnose`.",
            }
        )  # fmt: skip
    if not fit.converged:
        warnings.append({"code": "not_converged", "parameters": [], "text": fit.message})
    return warnings


def _free_scale(torques: list[str], reason: str) -> dict:
    return {
        "code": "free_scale", "parameters": torques,
        "text": f"No torque is measured and {reason}: {', '.join(torques)} are known only "
        "relative to B1.",
    }  # fmt: skip
