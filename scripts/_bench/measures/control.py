"""Variations of what bounds a step: ours only, each beside the engine as it is.

Nearly all steps of a run lie in its reversals; what they can be saved by, and at what error, is
what this shows. Errors are against the engine itself at a hundredth of the tolerance: which of two
variations is better needs no more.
"""

import numpy as np

from ..bench import Bench
from ..peers import ours
from ..problem import anywhere, sweep
from ..rows import Row, plain, smoothing

#: Arguments of `tp_jax.simulation.control.Control` by what they do.
VARIED: dict[str, dict[str, float]] = {
    "as it is": {},
    "reversals not come closer to at once (leap)": {"leap": 0.0},
    "stiff turns resolved too (crossing)": {"crossing": 0.0},
    "steps grow by 2 at most (growth)": {"growth": 2.0},
    "steps grow by 10 (growth)": {"growth": 10.0},
    "steps shrink to 0.3 at most (shrink)": {"shrink": 0.3},
    "0.7 of the time left to a reversal (approach)": {"approach": 0.7},
    "layer narrower (layer 0.3)": {"layer": 0.3},
    "layer wider (layer 0.7)": {"layer": 0.7},
    "sign straighter (friction 0.1)": {"friction": 0.1},
    "sign more bent (friction 0.3)": {"friction": 0.3},
    "velocities 3 times as wrong (velocity)": {"velocity": 0.9},
}
LOOKED = 1024
"""Draws among which the slowest are looked for."""
SLOWEST = 16
FINER = 100.0


def measure(b: Bench) -> tuple[dict, list[Row]]:
    """{"results": [{eps, runs, variation, changes, tolerance, steps, error}]}, medians of runs."""
    results, rows = [], []
    for eps in b.scale.eps:
        b.tell(f"control, {smoothing(eps)}")
        tol, _ = b.tolerance(b.ours, eps)
        draws = anywhere(min(b.scale.draws, LOOKED))
        _, steps = ours.steps(draws, eps, b.scale.ts, tol)
        slowest = draws[np.argsort(-steps)[:SLOWEST]]
        for runs, table in ("±20 %", sweep(b.scale.lanes)), ("slowest draws", slowest):
            fine = _angles(ours.motions(table, eps, b.scale.ts, tol / FINER, {}))
            usual: float | None = None
            for variation, changes in VARIED.items():
                done = ours.motions(table, eps, b.scale.ts, tol, changes)
                count = float(np.median(done.steps))
                # of a run the largest error; of runs the median, as some end in another branch
                error = float(np.median(np.abs(_angles(done) - fine).max(axis=(1, 2))))
                usual = usual or count
                results.append(
                    {
                        "eps": eps,
                        "runs": runs,
                        "variation": variation,
                        "changes": changes,
                        "tolerance": tol,
                        "steps": count,
                        "error": error,
                    }
                )
                text = f"{count:.0f} steps, error {error:.1e}"
                if changes:
                    text += f": {count / usual - 1.0:+.0%} steps"
                rows.append(plain("control", f"{runs}, {smoothing(eps)}", variation, text))
    return {"results": results}, rows


def _angles(done) -> np.ndarray:
    return np.stack([done.phi1, done.phi2], axis=-1)
