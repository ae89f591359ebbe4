"""Forward sensitivities: ten parameters and four initial states, in the run's tolerance.

Their error is relative to the largest value of each derivative; the largest of all counts. A
solver's control does not see the error of its tangents, so that a good run may have useless ones.
"""

import numpy as np

from .. import reference
from ..bench import Bench
from ..compared import CVODES, against
from ..peer import cores
from ..peers.ours import many_sensitivities
from ..pool import one as called
from ..pool import workers
from ..problem import DIRECTIONS, bench, sweep
from ..rows import BARS, Row, duration, held, plain, smoothing, times
from ..timing import interleaved, ratio, spread


def measure(b: Bench) -> tuple[dict, list[Row]]:
    """{"directions", "results": [{peer, eps, tolerance, errors, seconds, over_run, ...}], "many":
    [{eps, lanes, seconds_per_run, ours_over_peer}]}."""
    results, rows, many = [], [], []
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
        many.append(_many(b, eps, [one for one in found if one["peer"] in CVODES]))
        rows += _rows_of_many(b, smoothing(eps), many[-1])
    return {"directions": DIRECTIONS, "results": results, "many": many}, rows


def _many(b: Bench, eps: float, cvodes: list[dict]) -> dict:
    """Measures as many runs as a sweep has, ours on all cores; of CVODES' faster method four runs a
    core, in as many processes."""
    table, ts = sweep(b.scale.lanes), b.scale.ts
    tol = b.tolerance(b.ours, eps)[0]
    calls = {b.ours.name: lambda: many_sensitivities(table, eps, ts, tol)}
    usable = [one for one in cvodes if one["error"] <= BARS["tangents"][1]] or cvodes
    peer = min(usable, key=lambda one: one["seconds"]["median"], default=None)
    each = {b.ours.name: len(table)}
    if peer is not None:
        module = f"{__package__.rsplit('.', 1)[0]}.peers.{peer['peer'].replace('-', '_')}"
        some = table[: 4 * cores()]
        each[peer["peer"]] = len(some)

        def theirs():
            rest = (eps, ts, peer["tolerance"])
            tasks = [(module, "sensitivities", row, *rest) for row in some]
            return [f.result() for f in [workers().submit(called, *task) for task in tasks]]

        calls[peer["peer"]] = theirs
    readings = interleaved(calls, b.scale.pairs)
    readings = {name: [x / each[name] for x in values] for name, values in readings.items()}
    found = {
        "eps": eps,
        "lanes": len(table),
        "seconds_per_run": {name: spread(values)._asdict() for name, values in readings.items()},
    }
    if peer is not None:
        over = ratio(readings, b.ours.name, peer["peer"])
        found["ours_over_peer"] = {"peer": peer["peer"], **over._asdict()}
    return found


def _rows_of_many(b: Bench, case: str, found: dict) -> list[Row]:
    mine = found["seconds_per_run"][b.ours.name]["median"]
    where = f"{case}, {found['lanes']} runs"
    rows = [plain("sensitivities", where, b.ours.name, f"{duration(mine)} a run on all cores")]
    over = found.get("ours_over_peer")
    if over is not None:
        value = f"{times(over['median'])} {over['peer']}, on all cores too"
        rows.append(
            held(
                "sensitivities over cvodes",
                "sensitivities",
                where,
                b.ours.name,
                over["median"],
                value,
            )
        )
    return rows


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
