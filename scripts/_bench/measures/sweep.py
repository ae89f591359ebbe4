"""Many runs: parameter sets drawn around the preset, all cores, cost per run at equal error.

The error is the largest over all of a peer's runs. A peer that would take longer than `SLOW` for
them all gets as many of the first ones as fit, which the table says; ours always gets all.
"""

import time

import numpy as np

from .. import reference
from ..bench import Bench, largest, loosest
from ..compared import CVODES, against
from ..peer import Peer, cores
from ..problem import sweep
from ..rows import Row, plain, smoothing
from ..timing import interleaved, ratio, spread
from .single import accurate, listed

SLOW = 10.0  # s
SCOUTS = 6


def measure(b: Bench) -> tuple[dict, list[Row]]:
    """{"agreement", "results": [{peer, eps, lanes, threads, tolerance, error, seconds, ...}]}."""
    table = sweep(b.scale.lanes)
    results, agreements, rows = [], [], []
    for eps in b.scale.eps:
        b.tell(f"sweep, {smoothing(eps)}: references")
        truth = reference.angles(table, eps, b.scale.ts, b.scale.reference)
        method, difference = reference.agreement(table, eps, b.scale.ts, b.scale.reference)
        agreements.append({"eps": eps, "method": method, "difference": difference})
        value = f"{difference:.1e} rad between LSODA and {method}"
        rows.append(plain("sweep", smoothing(eps), "reference", value))

        found, calls = [], {}
        for peer in b.peers:
            b.tell(f"sweep, {smoothing(eps)}: {peer.name}")
            lanes, tol, error = _settled(b, peer, table, truth, eps)
            calls[peer.name] = lambda p=peer, n=lanes, tol=tol, eps=eps: p.sweep(
                table[:n], eps, b.scale.ts, tol
            )
            found.append(
                {
                    "peer": peer.name,
                    "eps": eps,
                    "lanes": lanes,
                    "threads": peer.threads,
                    "tolerance": tol,
                    "error": error,
                }
            )
        readings = interleaved(calls, b.scale.pairs, warm=True, budget=b.scale.budget)
        per_run = {
            one["peer"]: [seconds / one["lanes"] for seconds in readings[one["peer"]]]
            for one in found
        }
        for one in found:
            one["seconds"] = spread(per_run[one["peer"]])._asdict()
            one["ours_over_peer"] = ratio(per_run, b.ours.name, one["peer"])._asdict()
        results += found
        rows += listed("sweep", smoothing(eps), found)
        where = "sweep", smoothing(eps)
        rows += against("sweep over cvodes", where, found, CVODES, accurate)
        rows += against("sweep over numba", where, found, ("numba-dopri5",), accurate)
        rows += _on_gpu(smoothing(eps), found[0])
    return {"agreement": agreements, "results": results}, rows


def _settled(b: Bench, peer: Peer, table, truth, eps: float) -> tuple[int, float, float]:
    """Lanes, tolerance and error of a peer: a few single runs first, since sweeps may be long."""
    ts = b.scale.ts
    few = min(SCOUTS, len(table))
    scout = lambda tol: max(  # noqa: E731
        largest(peer.run(table[i], eps, ts, tol), truth[i]) for i in range(few)
    )
    start, _ = loosest(scout, b.schedule(peer), b.scale.cap)
    began = time.perf_counter()
    scout(start)
    alone = (time.perf_counter() - began) / few
    lanes = len(table)
    if peer.name != b.ours.name and alone * lanes / cores() > SLOW:
        # in whole loads of the cores
        lanes = max(1, int(SLOW / alone)) * cores()
        lanes = min(len(table), max(lanes, few))
    schedule = tuple(tol for tol in b.schedule(peer) if tol <= start)
    error_at = lambda tol: largest(peer.sweep(table[:lanes], eps, ts, tol), truth[:lanes])  # noqa: E731
    return lanes, *loosest(error_at, schedule, b.scale.cap)


def _on_gpu(case: str, ours: dict) -> list[Row]:
    from ..peers.ours import platform

    if platform() != "gpu":
        return []
    per_second = 1.0 / np.float64(ours["seconds"]["median"])
    return [plain("sweep", case, ours["peer"], f"{per_second:.4g} runs per second on the GPU")]
