"""Cross-validation inside the fitted data, from the information matrices alone.

Each recording is cut into contiguous parts; a fold is one part of every recording, another one of
each: how runs begin (the rider slips on all of them then) is not left out at once. Leaving a fold
out moves the unknowns by one Newton step, which the windows' gradients and information matrices
give without any simulation. Nuisances of a recording stay as they are, like the window states:
they are estimated wherever there is a recording. A combination of unknowns of which only one fold
tells (a decay is still after a second), or none (Ts1, Tst, T0), is not sent to where the
linearisation means nothing.
"""

import dataclasses

import numpy as np

from tp_jax.estimation.fitted import Fit, parameter
from tp_jax.estimation.layout import Unknown, Values

FOLDS = 5
NUISANCES = ("zero1", "zero2", "phase", "preload")
UNSEEN = 1e-6  # of the largest: a combination of unknowns with less information stays put
MOST_LEFT_OUT = 0.95  # of what is known of anything: beyond, one Newton step means nothing


def folds(fit: Fit, n: int = FOLDS) -> np.ndarray:
    """Fold of each window (w,)."""
    w = fit.problem.windows
    out = np.zeros(w.n, dtype=int)
    for i, r in enumerate(np.unique(w.recording)):
        mine = np.flatnonzero(w.recording == r)
        part = np.minimum(np.arange(mine.size) * n // mine.size, n - 1)
        out[mine] = (part + i) % n
    return out


@dataclasses.dataclass(frozen=True)
class Moves:
    """Moves of unknowns when groups of windows are left out, by one Newton step.

    unknowns: those that follow; steps: (G, u), one for each group and unknown.
    """

    unknowns: tuple[Unknown, ...]
    steps: np.ndarray

    def values(self, fit: Fit, group: int) -> Values:
        """The numbers of a fit with the unknowns moved, kept within their bounds."""
        x = []
        for u, dx in zip(self.unknowns, self.steps[group], strict=True):
            spec, at = parameter(fit.problem, u), _value(fit, u)
            new = spec.from_coordinate(spec.to_coordinate(at) + dx / spec.slope(at))
            x.append(float(np.clip(new, spec.lower, spec.upper)))
        return fit.values.put(self.unknowns, np.array(x))


def moves(fit: Fit, fold: np.ndarray) -> Moves:
    """Computes how unknowns move when each fold is left out.

    Args:
        fit: at its optimum, or near it.
        fold: of each window (w,), from 0 on.
    """
    free = ~fit.at_bound & np.array([_moves(fit, u) for u in fit.unknowns])
    names = [u for u, f in zip(fit.unknowns, free, strict=True) if f]
    g, H = fit.eliminated.sums(fold)
    g, H = g[:, free], H[:, free][:, :, free]
    normal = fit.normal()
    total = normal.part(free).information
    scale = np.sqrt(np.maximum(np.diag(total), 1e-300))
    # coordinates in which all that is known makes a unit matrix
    value, vector = np.linalg.eigh(total / np.outer(scale, scale))
    seen = value > UNSEEN * value.max(initial=0.0)
    white = vector[:, seen] / np.sqrt(value[seen]) / scale[:, None]
    # A fit that ended early is taken for what it is near to: what is left of its gradient says
    # nothing about any fold.
    left = white.T @ normal.g[free]  # the priors' part too
    steps = np.zeros((len(g), len(names)))
    for k in np.unique(fold):
        mine = white.T @ H[k] @ white
        part, axes = np.linalg.eigh(mine)
        rest = 1.0 - np.minimum(part, MOST_LEFT_OUT)
        steps[k] = white @ (axes @ ((axes.T @ (white.T @ g[k] - mine @ left)) / rest))
    return Moves(tuple(names), steps)


def left_out_cost(fit: Fit, fold: np.ndarray | None = None) -> np.ndarray:
    """Sum of squares of each window (w,) under unknowns fitted without its fold.

    Args:
        fit: at its optimum, or near it.
        fold: of each window (w,); `folds` if None.
    """
    fold = folds(fit) if fold is None else fold
    found = moves(fit, fold)
    told = fit.eliminated
    steps = np.zeros((len(found.steps), len(fit.unknowns)))
    steps[:, [fit.unknowns.index(u) for u in found.unknowns]] = found.steps
    step = told.own(steps[fold])
    return (
        told.cost
        + 2.0 * np.einsum("wk,wk->w", told.g, step)
        + np.einsum("wk,wkl,wl->w", step, told.H, step)
    )


def _value(fit: Fit, unknown: Unknown) -> float:
    return fit.values.get(unknown.name, unknown.recording)


def _moves(fit: Fit, unknown: Unknown) -> bool:
    """True where an unknown follows when a fold is left out.

    Shape constants stay, as they do where they come from a grid: one Newton step of a constant that
    enters so nonlinearly leads anywhere.
    """
    shape = "." in unknown.name and parameter(fit.problem, unknown).transform == "log"
    return not shape and unknown.name not in NUISANCES


def gain(before: np.ndarray, after: np.ndarray, block: np.ndarray) -> tuple[float, float]:
    """Drop of the left-out sum of squares and its standard error, from the scatter of blocks."""
    d = np.zeros(block.max() + 1)
    np.add.at(d, block, before - after)
    n = d.size
    error = float(d.std(ddof=1) * np.sqrt(n)) if n > 1 else np.inf
    return float(d.sum()), error
