"""Results as plain numbers, for JSON: tables by name, at most a hundred times each."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from tp_jax.identifiability.rank import Rank
from tp_jax.sensitivity_analysis.local import Local
from tp_jax.sensitivity_analysis.morris import Morris
from tp_jax.sensitivity_analysis.ranges import Range
from tp_jax.sensitivity_analysis.sobol import Sobol

MOST_TIMES = 101
DIGITS = 6


def structural(found: Rank) -> dict[str, Any]:
    """Ranks and singular values at the random points."""
    return {
        "parameters": list(found.names),
        "recordings": list(found.designs),
        "points": len(found.points),
        "rank": found.rank,
        "of": len(found.names),
        "ranks": found.ranks.tolist(),
        "gap": found.gap,
        "singular_values": _rounded(found.singular_values),
        "weakest": [
            {n: float(x) for n, x in zip(found.names, _rounded(row), strict=True)}
            for row in found.weakest
        ],
    }


def local_record(runs: Sequence[Local], scale: dict[str, float]) -> dict[str, Any]:
    """Derivatives through time [rad per relative change], and their rms."""
    out = []
    for r in runs:
        pick = np.unique(np.linspace(0, r.t.size - 1, MOST_TIMES).round().astype(int))
        out.append(
            {
                "recording": r.label,
                "t": _rounded(r.t[pick]),
                **{c: _columns(r.names, e[pick]) for c, e in r.effect.items()},
                "rms": {c: _named(r.names, x) for c, x in r.rms.items()},
                "reliable": {n: bool(x) for n, x in zip(r.names, r.reliable, strict=True)},
                "growth": float(r.growth),
            }
        )
    return {
        "unit": "rad per relative change of the parameter",
        "scale": {n: float(x) for n, x in scale.items()},
        "rms": _largest(runs[0].names, [r.rms for r in runs]),
        "recordings": out,
    }


def sobol_record(runs: Sequence[Sobol], over: Sequence[Range], samples: int) -> dict[str, Any]:
    """Indices of each recording, whole and through time."""
    out = []
    for r in runs:
        entry: dict[str, Any] = {"recording": r.label, "t": _rounded(r.t), "runs": r.runs}
        for c in r.first:
            entry[c] = {
                "S1": _named(r.names, r.first_whole[c]),
                "S1_conf": _named(r.names, r.first_error[c]),
                "ST": _named(r.names, r.total_whole[c]),
                "ST_conf": _named(r.names, r.total_error[c]),
                "through_time": {
                    "variance": _rounded(r.variance[c]),
                    "S1": _columns(r.names, r.first[c]),
                    "ST": _columns(r.names, r.total[c]),
                },
            }
        out.append(entry)
    return {
        "ranges": {r.name: [r.low, r.high] for r in over},
        "samples": samples,
        "S1": _largest(runs[0].names, [r.first_whole for r in runs]),
        "ST": _largest(runs[0].names, [r.total_whole for r in runs]),
        "recordings": out,
    }


def morris_record(runs: Sequence[Morris], over: Sequence[Range], count: int) -> dict[str, Any]:
    """Elementary effects of each recording, whole and through time."""
    out = []
    for r in runs:
        entry: dict[str, Any] = {"recording": r.label, "t": _rounded(r.t), "runs": r.runs}
        for c in r.mu_star:
            entry[c] = {
                "mu_star": _named(r.names, r.mu_star_whole[c]),
                "mu_star_conf": _named(r.names, r.mu_star_error[c]),
                "sigma": _named(r.names, r.sigma_whole[c]),
                "through_time": {
                    "mu_star": _columns(r.names, r.mu_star[c]),
                    "sigma": _columns(r.names, r.sigma[c]),
                },
            }
        out.append(entry)
    return {
        "unit": "rad per whole range of the parameter",
        "ranges": {r.name: [r.low, r.high] for r in over},
        "trajectories": count,
        "mu_star": _largest(runs[0].names, [r.mu_star_whole for r in runs]),
        "recordings": out,
    }


def _largest(names: Sequence[str], tables: Sequence[dict[str, np.ndarray]]) -> dict[str, Any]:
    """Channel -> parameter -> the largest of all recordings."""
    return {c: _named(names, np.max([t[c] for t in tables], axis=0)) for c in tables[0]}


def _named(names: Sequence[str], row: np.ndarray) -> dict[str, float | None]:
    return dict(zip(names, _rounded(row), strict=True))


def _columns(names: Sequence[str], table: np.ndarray) -> dict[str, list]:
    return {n: _rounded(table[:, i]) for i, n in enumerate(names)}


def _rounded(values: np.ndarray) -> list:
    """Rounds to six digits: more would be the solver's, and twice the file."""
    values = np.asarray(values, float)
    if values.ndim > 1:
        return [_rounded(row) for row in values]
    return [float(f"{x:.{DIGITS}g}") if np.isfinite(x) else None for x in values.tolist()]
