"""Forward sensitivities: ten parameters and four initial states, in the run's tolerance.

Their error is relative to the largest value of each derivative; the largest of all counts. A
solver's control does not see the error of its tangents, so that a good run may have useless ones.
"""

import numpy as np

from .. import reference
from ..bench import Bench
from ..compared import CVODES, against
from ..problem import DIRECTIONS, bench
from ..rows import BARS, Row, duration, held, plain, smoothing
from ..timing import interleaved, ratio, spread


def measure(b: Bench) -> tuple[dict, list[Row]]:
    """{"directions", "results": [{peer, eps, tolerance, errors, seconds, over_run, ...}]}."""
    results, rows = [], []
    able = [peer for peer in b.peers if peer.sensitivities is not None]
    ts, row = b.scale.ts, bench()
    for eps in b.scale.eps:
        truth = reference.sensitivities(row, eps, ts, b.scale.reference)
        calls, errors = {}, {}
        for peer in able:
            b.tell(f"sensitivities, {smoothing(eps)}: {peer.name}")
            tol, _ = b.tolerance(peer, eps)
            calls[peer.name] = lambda p=peer, eps=eps, tol=tol: p.sensitivities(row, eps, ts, tol)
            calls[f"{peer.name} run"] = lambda p=peer, eps=eps, tol=tol: p.run(row, eps, ts, tol)
            values = peer.sensitivities(row, eps, ts, tol)
            errors[peer.name] = _relative(values, truth)
        readings = interleaved(calls, b.scale.pairs, budget=b.scale.budget)
        found = [
            {
                "peer": peer.name,
                "eps": eps,
                "tolerance": b.tolerance(peer, eps)[0],
                "errors": errors[peer.name],
                "error": float(np.max(errors[peer.name])),
                "seconds": spread(readings[peer.name])._asdict(),
                "over_run": ratio(readings, peer.name, f"{peer.name} run")._asdict(),
                "ours_over_peer": ratio(readings, b.ours.name, peer.name)._asdict(),
            }
            for peer in able
        ]
        results += found
        rows += _rows(b, smoothing(eps), found)
    return {"directions": DIRECTIONS, "results": results}, rows


def _relative(values: np.ndarray, truth: np.ndarray) -> np.ndarray:
    errors = np.max(np.abs(values - truth), axis=(0, 1)) / np.max(np.abs(truth), axis=(0, 1))
    return np.where(np.isfinite(errors), errors, np.inf)


def _rows(b: Bench, case: str, found: list[dict]) -> list[Row]:
    rows = []
    for one in found:
        over = one["over_run"]["median"]
        value = f"{duration(one['seconds']['median'])}, {over:.3g} runs, error {one['error']:.1e}"
        if one["peer"] == b.ours.name:
            rows.append(
                held("sensitivities over run", "sensitivities", case, one["peer"], over, value)
            )
        else:
            r = one["ours_over_peer"]
            value += f"; ours takes {r['median']:.2g} × that ({r['low']:.2g} to {r['high']:.2g})"
            rows.append(plain("sensitivities", case, one["peer"], value))
    error = found[0]["error"]
    rows.append(
        held("tangents", "sensitivities", case, b.ours.name, error, f"largest error {error:.1e}")
    )
    usable = BARS["tangents"][1]
    where = "sensitivities", case
    return rows + against(
        "sensitivities over cvodes", where, found, CVODES, lambda one: one["error"] <= usable
    )
