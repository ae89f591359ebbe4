"""The windows' own states at given numbers: each window fitted by itself.

Gauss-Newton over unknowns and states together takes a wrong step wherever a single window's state
answers nonlinearly (a rider that sticks here and slides there), and is refused as a whole for it.
Windows share nothing but the unknowns, so those few are put right by themselves, and only they
are integrated again.
"""

import dataclasses
from collections.abc import Sequence

import numpy as np

from tp_jax.estimation.layout import Values
from tp_jax.estimation.least_squares import MAX_STATE_STEP
from tp_jax.estimation.linearisation import Linearisation
from tp_jax.estimation.problem import Problem
from tp_jax.estimation.robust import Loss, robust
from tp_jax.estimation.windows import Windows

ROUNDS = 8
FIRST = 1e-3
#: Damping from which on a window's state is as good as it gets: it lies in a kink, where the rider
#: just sticks, and no derivative knows.
HOPELESS = 1e2
STATES_ALONE = 0.25  # of the time of an evaluation with all derivatives


@dataclasses.dataclass
class Settled:
    """states: (w, 4) at which no window promises to gain; lin: there; passes: over the data, in
    evaluations of all windows with all derivatives; damping: (w,) to begin with next time."""

    states: np.ndarray
    lin: Linearisation
    passes: float
    damping: np.ndarray


def of_windows(problem: Problem, which: np.ndarray) -> Problem:
    """The problem of some of the windows, in the order given."""
    w = problem.windows
    windows = Windows(w.recording[which], w.first[which], w.count[which], w.horizon)
    return dataclasses.replace(problem, windows=windows)


def in_turn(windows: Windows, which: np.ndarray) -> np.ndarray:
    """Windows ordered so that neighbours are of different recordings.

    A lane holds windows of one recording, so that these are spread over the lanes of a block
    instead of queueing up in a few.
    """
    recording = windows.recording[which]
    rank = np.zeros(which.size, int)
    for r in np.unique(recording):
        rank[recording == r] = np.arange((recording == r).sum())
    return which[np.lexsort((recording, rank))]


def costs(lin: Linearisation) -> np.ndarray:
    """Sum of squares by window (w,); infinite where it could not be integrated."""
    return np.where(lin.complete, (lin.r**2).sum(axis=1), np.inf)


def settle(
    problem: Problem,
    values: Values,
    states: np.ndarray,
    lin: Linearisation,
    slots: Sequence[str],
    *,
    tolerance: float = 0.01,
    damping: np.ndarray | None = None,
    loss: Loss = "linear",
) -> Settled:
    """Fits each window's state to the window, all numbers held.

    Args:
        problem: recordings in windows.
        values: all numbers.
        states: (w, 4) start.
        lin: linearisation there; changed in place where a state moves.
        slots: it is differentiated by.
        tolerance: a window is left alone whose state promises a smaller drop of its sum of
            squares.
        damping: (w,) of Levenberg and Marquardt, as the last call returned it: a window that
            could not be put right then is tried only once more.
        loss: see `robust`.
    """
    states = states.copy()
    damping = np.full(problem.windows.n, FIRST) if damping is None else damping.copy()
    damping = np.minimum(damping, 0.9 * HOPELESS)
    cost = costs(lin)
    touched = np.zeros(problem.windows.n, dtype=bool)
    passes, total = 0.0, problem.windows.count.sum()
    for _ in range(ROUNDS):
        step, promise = state_steps(lin, damping)
        open_ = np.flatnonzero(lin.complete & (promise > tolerance) & (damping < HOPELESS))
        if not open_.size:
            break
        open_ = in_turn(problem.windows, open_)
        part = of_windows(problem, open_)
        moved = states[open_] + np.clip(step[open_], -MAX_STATE_STEP, MAX_STATE_STEP)
        new = robust(part.linearise(values, moved, ()), loss)  # by the states alone: far cheaper
        passes += STATES_ALONE * part.windows.count.sum() / total
        at_new = costs(new)
        better = at_new < cost[open_]
        gained = open_[better]
        states[gained], cost[gained] = moved[better], at_new[better]
        touched[gained] = True
        put(lin, new, gained, better)
        damping[gained] = np.maximum(0.1 * damping[gained], 1e-9)
        damping[open_[~better]] = 30.0 * np.maximum(damping[open_[~better]], FIRST)
    if slots and touched.any():
        again = in_turn(problem.windows, np.flatnonzero(touched))
        full = of_windows(problem, again).linearise(values, states[again], slots)
        passes += problem.windows.count[again].sum() / total
        put(lin, robust(full, loss), again, np.ones(again.size, dtype=bool))
    return Settled(states, lin, passes, damping)


def put(lin: Linearisation, part: Linearisation, where: np.ndarray, which: np.ndarray) -> None:
    """Some windows' rows of a part into the whole; without derivatives by slots if it has none."""
    rows = part.r.shape[1] - 4
    by_slots = ("slots_jac",) if part.slots else ()
    for name in ("r", "states_jac", "valid", *by_slots):
        whole, new = getattr(lin, name), getattr(part, name)[which]
        whole[where, :rows] = new[:, :rows]
        whole[where, -4:] = new[:, -4:]
    if lin.raw is not None and part.raw is not None:
        lin.raw[where, :rows] = part.raw[which][:, :rows]
    lin.states[where, : part.n_samples] = part.states[which]
    if lin.own is not None and part.own is not None:
        lin.own[where] = part.own[which]
    lin.complete[where] = part.complete[which]


def state_steps(lin: Linearisation, damping: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Damped steps of the states (w, 4), and what the full ones promise (w,)."""
    xt = lin.states_jac.transpose(0, 2, 1)
    g = (xt @ lin.r[:, :, None])[..., 0]
    H = xt @ lin.states_jac
    diagonal = np.einsum("wii->wi", H)
    floor = np.maximum(1e-12 * diagonal.max(axis=1, keepdims=True), 1e-300)
    full = np.linalg.solve(H + floor[:, :, None] * np.eye(4), g[..., None])[..., 0]
    damped = H + (damping[:, None] * diagonal + floor)[:, :, None] * np.eye(4)
    step = -np.linalg.solve(damped, g[..., None])[..., 0]
    return step, np.einsum("wi,wi->w", g, full)
