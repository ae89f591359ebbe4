"""Section 5.1: the simulated rig, from the paper's starting set, method by method."""

from typing import Any

import numpy as np

from scripts._paper import free_run, nelder_mead, windows
from scripts._paper.objective import ORDER, Objective, of_preset
from scripts._paper.scale import Scale
from scripts._paper.truth import NOISE, OMEGA, SLIPPING, recorded

#: What a column and a rider that never part show: the printed (16) with phi2 = 0.
STUCK = {
    "k / (B1 + 2 B2)": lambda p: p["k"] / (p["B1"] + 2.0 * p["B2"]),
    "c1 / (B1 + 2 B2)": lambda p: p["c1"] / (p["B1"] + 2.0 * p["B2"]),
    "M1 / (B1 + 2 B2)": lambda p: p["M1"] / (p["B1"] + 2.0 * p["B2"]),
    "A": lambda p: p["A"],
}


def run(scale: Scale, tell) -> dict[str, Any]:
    """All methods, on the printed run and on one in which the rider slips."""
    truth, start = of_preset("paper-5.1"), of_preset("paper-5.1-start")
    out: dict[str, Any] = {"runs": {}, "order": list(ORDER), "start": start.tolist()}
    for key, omega in (("printed", OMEGA), ("slipping", SLIPPING)):
        exact = recorded(truth, omega, scale.ts)
        noisy = recorded(truth, omega, scale.ts, NOISE, seed=scale.seed)
        out["runs"][key] = {
            "omega": omega,
            "y_start": exact.of_x(start),
            "methods": _methods(exact, noisy, truth, start, scale, f"Section 5.1, {key}", tell),
        }
    return out


def _methods(
    exact: Objective, noisy: Objective, truth, start, scale: Scale, where: str, tell
) -> list[dict[str, Any]]:
    """Nelder-Mead has the recording without noise, as in the paper; windows have it with."""
    rows = []
    for name, iterations in (
        ("Nelder-Mead, 50 iterations", scale.listing),
        ("Nelder-Mead, thousands", scale.thousands),
    ):
        tell(f"{where}: {name}")
        rows.append(_row(name, nelder_mead.search(exact, start, iterations), truth, "y"))
    tell(f"{where}: gradients on the whole run")
    rows.append(
        _row("gradients, whole run", free_run.search(exact, start, scale.gradients), truth, "y")
    )
    tell(f"{where}: gradients on windows")
    found, fit, _ = windows.search([noisy], start[0], start, judged_by=exact)
    row = _row("gradients, windows", found, truth, "chi2")
    row["chi2_dof"] = fit.chi2_dof
    rows.append(row)
    return rows


def _row(name: str, found: nelder_mead.Searched, truth, objective: str) -> dict[str, Any]:
    return {
        "method": name,
        "objective": objective,
        "evaluations": found.evaluations,
        "seconds": found.seconds,
        "y": found.y,
        "x": dict(zip(ORDER, found.x.tolist(), strict=True)),
        "errors": errors(found.x, truth),
        "stuck_errors": stuck_errors(found.x, truth),
        "history": _thinned(found.history),
        "message": found.message,
    }


def errors(x, truth) -> dict[str, float]:
    """Relative errors of what has a scale of its own: torques by B1, amplitude, T0."""
    x, truth = np.asarray(x, float), np.asarray(truth, float)
    out = {}
    for i, n in enumerate(ORDER):
        if n in ("B1", "Ts2"):
            continue
        if n in ("A", "T0"):
            found, true = x[i], truth[i]
        else:
            found, true = x[i] / x[0], truth[i] / truth[0]
        out[n] = float(found / true - 1.0)
    return out


def stuck_errors(x, truth) -> dict[str, float]:
    """Relative errors of the four numbers that a run without slip shows."""
    a, b = (dict(zip(ORDER, np.asarray(v, float).tolist(), strict=True)) for v in (x, truth))
    return {name: float(of(a) / of(b) - 1.0) for name, of in STUCK.items()}


def _thinned(history: list[float], most: int = 400) -> dict[str, list]:
    """y by evaluation, at evaluations that are even in the logarithm."""
    if not history:
        return {"evaluation": [], "y": []}
    pick = np.unique(np.geomspace(1, len(history), most).round().astype(int))
    return {"evaluation": pick.tolist(), "y": [history[i - 1] for i in pick]}
