"""One run: what each peer takes for the same error."""

from collections.abc import Mapping, Sequence
from typing import Any

from ..bench import TARGET, Bench
from ..compared import CVODES, against
from ..problem import bench
from ..rows import Row, duration, plain, smoothing
from ..timing import interleaved, ratio, spread


def measure(b: Bench) -> tuple[dict, list[Row]]:
    """{"results": [{peer, eps, tolerance, error, seconds, ours_over_peer}]}."""
    results, rows = [], []
    for eps in b.scale.eps:
        b.tell(f"single, {smoothing(eps)}")
        chosen = {peer.name: b.tolerance(peer, eps) for peer in b.peers}
        calls = {
            peer.name: lambda peer=peer, eps=eps: peer.run(
                bench(), eps, b.scale.ts, b.tolerance(peer, eps)[0]
            )
            for peer in b.peers
        }
        readings = interleaved(calls, b.scale.pairs, budget=b.scale.budget)
        found = [
            {
                "peer": name,
                "eps": eps,
                "tolerance": chosen[name][0],
                "error": chosen[name][1],
                "seconds": spread(readings[name])._asdict(),
                "ours_over_peer": ratio(readings, b.ours.name, name)._asdict(),
            }
            for name in calls
        ]
        results += found
        rows += listed("single", smoothing(eps), found)
        where = "single", smoothing(eps)
        rows += against("single over cvodes", where, found, CVODES, accurate)
        rows += against("single over tsit5", where, found, ("diffrax-tsit5",), accurate)
    return {"results": results}, rows


def accurate(one: Mapping[str, Any]) -> bool:
    """True if a result has the error asked for."""
    return one["error"] <= TARGET


def listed(measure: str, case: str, found: Sequence[Mapping[str, Any]]) -> list[Row]:
    """A row for each peer; ours comes first."""
    rows = []
    for one in found:
        value = f"{duration(one['seconds']['median'])}, error {one['error']:.1e}"
        if not accurate(one):
            value += " (its best)"
        if "lanes" in one:
            value += f", {one['lanes']} lanes"
        if one is not found[0]:
            r = one["ours_over_peer"]
            value += f"; ours takes {r['median']:.2g} × that ({r['low']:.2g} to {r['high']:.2g})"
        rows.append(plain(measure, case, one["peer"], value))
    return rows
