"""Error of a run against its cost, for each peer over a ladder of tolerances."""

from ..bench import Bench, largest
from ..problem import bench
from ..rows import Row, duration, plain, smoothing

FINE = 1e-9
"""Errors below this [rad] are the reference's as much as the peer's."""


def measure(b: Bench) -> tuple[dict, list[Row]]:
    """Points of the work-precision diagram: {"curves": [{peer, eps, points}]}."""
    curves, rows = [], []
    for eps in b.scale.eps:
        truth = b.truth(bench(), eps, b.scale.ts)
        for peer in b.peers:
            b.tell(f"precision, {smoothing(eps)}: {peer.name}")
            points = _ladder(b, peer, eps, truth)
            curves.append({"peer": peer.name, "eps": eps, "points": points})
            if points:
                best = min(points, key=lambda point: point["error"])
                value = f"{best['error']:.1e} rad in {duration(best['seconds'])}"
                rows.append(plain("precision", smoothing(eps), peer.name, value))
    return {"curves": curves}, rows


def _ladder(b: Bench, peer, eps, truth) -> list[dict]:
    points, given_up = [], 0
    for tol in b.scale.tolerances:
        took, angles = b.timed(peer, bench(), eps, tol)
        if angles is None:
            given_up += 1
            if given_up == 2:
                break
            continue  # the loosest may be dearer than the next: Newton's iteration fails
        error = largest(angles, truth)
        if error < 1.0:  # beyond a radian there is no curve left, only a wrong motion
            points.append({"tolerance": tol, "error": error, "seconds": took})
        if error < FINE:
            break
    return points
