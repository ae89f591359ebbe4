"""Curves and residuals of the held-out recordings, thinned, for a report to draw."""

from typing import Any

import numpy as np

from tp_jax.estimation.baseline import Setting
from tp_jax.gap.calibration import Floor
from tp_jax.gap.held_out import HeldOut

THINNED = 600  # points of a curve in the result


def recordings(setting: Setting, before: dict, after: dict, explained: bool) -> list[dict]:
    """The recordings, and the estimated states at the start of those held out."""
    rows = []
    for i, r in enumerate(setting.recordings):
        start = {}
        if i in before:
            start = {"before": before[i].tolist()}
            if explained:
                start["after"] = after[i].tolist()
        rows.append(
            {
                "label": r.label, "file": r.name, "sha256": r.sha256, "held_out": r.held_out,
                "forced": r.forced, "omega": r.omega, "begin": float(r.t[0]),
                "duration": r.duration, "samples": r.n, "started": r.started, "start": start,
            }
        )  # fmt: skip
    return rows


def _thin(n: int) -> np.ndarray:
    return np.unique(np.linspace(0, n - 1, min(n, THINNED)).round().astype(int))


def curves(
    setting: Setting, before: dict[int, np.ndarray] | None, after: dict[int, np.ndarray] | None
) -> list[dict]:
    """Free runs of the held-out recordings beside what was measured [rad]."""
    out = []
    for i in setting.held_out:
        assert before is not None  # what is held out has free runs
        p = setting.prepared[i]
        keep = _thin(p.t.size)
        row: dict[str, Any] = {"recording": setting.recordings[i].label, "t": p.t[keep].tolist()}
        for c, name in enumerate(("phi1", "phi2")):
            row[name] = None
            if p.channels[c]:
                row[name] = {
                    "measured": p.y[keep, c].tolist(),
                    "before": before[i][keep, c].tolist(),
                    "after": None if after is None else after[i][keep, c].tolist(),
                }
        out.append(row)
    return out


def residuals(setting: Setting, before: HeldOut, after: HeldOut | None, least: Floor) -> list[dict]:
    """Windowed residuals of the held-out recordings in units of the floor.

    NaN in a window through which the model could not be integrated.
    """
    out = []
    total = least.total.items()
    windows = before.fit.problem.windows
    for i in setting.held_out:
        p = setting.prepared[i]
        unit = {n: s / x if x else 1.0 for s, (n, x) in zip(p.sigma, total, strict=False)}
        mine = np.flatnonzero(windows.recording == i)
        series = {}
        for name, held in (("before", before), ("after", after)):
            if held is None:
                series[name] = None
                continue
            lin = held.fit.linearisation
            r = np.where(lin.complete[:, None], lin.samples, np.nan)
            rows = [r[j, : 2 * windows.count[j]].reshape(-1, 2) for j in mine]
            series[name] = np.concatenate(rows)
        keep = _thin(p.t.size)
        row: dict[str, Any] = {"recording": setting.recordings[i].label, "t": p.t[keep].tolist()}
        for c, name in enumerate(("phi1", "phi2")):
            row[name] = None
            if p.channels[c]:
                row[name] = {
                    k: None if x is None else (x[keep, c] * unit[name]).tolist()
                    for k, x in series.items()
                }
        out.append(row)
    return out
