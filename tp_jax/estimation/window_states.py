"""The windows' own states at given numbers: each window fitted by itself.

Gauss-Newton over unknowns and states together takes a wrong step wherever a single window's state
answers nonlinearly (a rider that sticks here and slides there), and is refused as a whole for it.
Windows share nothing but the unknowns, so those few are put right by themselves, and only they
are integrated again.

Where the rider of a window just sticks, the window's sum of squares has a kink, and its state ends
there, with slopes on both sides that point to the other. The way further down leads along the kink:
against the shortest mean of the slopes of both sides, which a step that was refused tells.

A window in which a body comes to rest may keep a state that moves, in a minimum of its own. The
window before it knows better: `rejoin` lets windows begin where that one ended, if they fit better.

Source: Wolfe (1975), Math. Program. Study 3:145; Lemarechal (1975), Math. Program. Study 3:95.
"""

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np

from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.layout import Values
from tp_jax.estimation.linearisation import Linearisation
from tp_jax.estimation.problem import Problem
from tp_jax.estimation.robust import Loss, robust
from tp_jax.estimation.windows import Windows

MAX_STATE_STEP = np.array([0.05, 0.05, 2.0, 2.0])
"""Longest step of a window's state: rad, rad/s."""

ROUNDS = 8
FIRST = 1e-3
#: Damping from which on a window's state is as good as it gets: it lies in a kink, where the rider
#: just sticks, and no derivative knows.
HOPELESS = 1e2
KINK = 1.0  # a settled window that promises to gain more than this lies in a kink
KINK_ROUNDS = 16  # steps along kinks, of a few windows each; later ones gain next to nothing
APART = 10.0  # standard errors from where the window before ended: a state of another minimum
REJOINED = 3  # rounds: where a window has moved, the next one has another start
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
    kinks: bool = False,
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
        kinks: whether windows that end in a kink go on along it.
    """
    states = states.copy()
    damping = np.full(problem.windows.n, FIRST) if damping is None else damping.copy()
    damping = np.minimum(damping, 0.9 * HOPELESS)
    cost = costs(lin)
    touched = np.zeros(problem.windows.n, dtype=bool)
    passes, total = 0.0, problem.windows.count.sum()

    def tried(which: np.ndarray, step: np.ndarray) -> tuple[np.ndarray, Linearisation]:
        """Moves those of some windows' states that gain by a step; which, and where all were."""
        nonlocal passes
        part = of_windows(problem, which)
        moved = states[which] + np.clip(step, -MAX_STATE_STEP, MAX_STATE_STEP)
        new = robust(part.linearise(values, moved, ()), loss)  # by the states alone: far cheaper
        passes += STATES_ALONE * part.windows.count.sum() / total
        at_new = costs(new)
        better = at_new < cost[which]
        gained = which[better]
        states[gained], cost[gained] = moved[better], at_new[better]
        touched[gained] = True
        put(lin, new, gained, better)
        return better, new

    for _ in range(ROUNDS):
        step, promise = state_steps(lin, damping)
        open_ = np.flatnonzero(lin.complete & (promise > tolerance) & (damping < HOPELESS))
        if not open_.size:
            break
        open_ = in_turn(problem.windows, open_)
        better, _ = tried(open_, step[open_])
        gained = open_[better]
        damping[gained] = np.maximum(0.1 * damping[gained], 1e-9)
        damping[open_[~better]] = 30.0 * np.maximum(damping[open_[~better]], FIRST)
    if kinks:
        least, (beyond, _) = max(tolerance, KINK), state_equations(lin)
        share = np.ones(problem.windows.n)  # of a step
        kinked = lin.complete & (state_steps(lin, damping)[1] > least)
        for _ in range(KINK_ROUNDS):
            step, promise = steps_along_kinks(lin, beyond)
            open_ = np.flatnonzero(kinked & lin.complete & (promise > tolerance))
            if not open_.size:
                break
            open_ = in_turn(problem.windows, open_)
            better, new = tried(open_, (share[:, None] * step)[open_])
            share[open_] = np.where(better, np.minimum(2.0 * share[open_], 1.0), 0.5 * share[open_])
            far = ~better & new.complete
            beyond[open_[far]] = state_equations(new)[0][far]
    if slots and touched.any():
        again = in_turn(problem.windows, np.flatnonzero(touched))
        full = of_windows(problem, again).linearise(values, states[again], slots)
        passes += problem.windows.count[again].sum() / total
        put(lin, robust(full, loss), again, np.ones(again.size, dtype=bool))
    return Settled(states, lin, passes, damping)


def rejoin(
    problem: Problem,
    values: Values,
    states: np.ndarray,
    lin: Linearisation,
    slots: Sequence[str],
    *,
    tolerance: float = 0.01,
    loss: Loss = "linear",
) -> tuple[float, float]:
    """Begins windows anew where the window before them ended, if that fits better.

    Only those of which it is far enough away to be another minimum.

    Args:
        problem, values, slots, tolerance, loss: see `settle`.
        states: (w, 4); changed in place, and so is `lin`, the linearisation there.

    Returns:
        By how much the sum of squares fell, and passes over the data.
    """
    w = problem.windows
    before, ended = _ends_before(problem, lin)
    gain = passes = 0.0
    for _ in range(REJOINED):
        cost = costs(lin)
        which = np.flatnonzero((before >= 0) & lin.complete[before])
        jump = ended(which) - states[which]
        square = np.einsum("wi,wij,wj->w", jump, state_equations(lin)[1][which], jump)
        # a window that could not be integrated has no derivatives, and nothing to lose
        which = in_turn(w, which[(square > APART**2) | ~lin.complete[which]])
        if not which.size:
            break
        part = of_windows(problem, which)
        begun = ended(which)
        new = robust(part.linearise(values, begun, ()), loss)
        found = settle(part, values, begun, new, (), tolerance=tolerance, loss=loss)
        share = part.windows.count.sum() / w.count.sum()
        passes += share * (STATES_ALONE + found.passes)
        better = costs(found.lin) < cost[which] - KINK
        if not better.any():
            break
        moved = in_turn(w, which[better])
        states[which[better]] = found.states[better]
        full = of_windows(problem, moved).linearise(values, states[moved], slots)
        passes += w.count[moved].sum() / w.count.sum()
        put(lin, robust(full, loss), moved, np.ones(moved.size, dtype=bool))
        gain += float((cost - costs(lin))[moved].sum())
    return gain, passes


def _ends_before(
    problem: Problem, lin: Linearisation
) -> tuple[np.ndarray, Callable[[np.ndarray], np.ndarray]]:
    """The window that ends where a window begins (w,), -1 where there is none, and a function that
    gives the states (m, 4) in which windows begin then, a sample after those before them."""
    w = problem.windows
    windows = zip(w.recording, w.first, w.count, strict=True)
    ends = {(r, f + n): i for i, (r, f, n) in enumerate(windows)}
    before = np.array([ends.get(key, -1) for key in zip(w.recording, w.first, strict=True)])
    step = np.zeros(w.n)
    for i in np.flatnonzero(before >= 0):
        t = problem.prepared[w.recording[i]].t
        step[i] = t[w.first[i]] - t[w.first[i] - 1]

    def ended(which: np.ndarray) -> np.ndarray:
        j = before[which]
        last = lin.states[j, w.count[j] - 1, :4].copy()
        last[:, :2] += step[which, None] * last[:, 2:]
        return last

    return before, ended


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


def state_equations(lin: Linearisation) -> tuple[np.ndarray, np.ndarray]:
    """Half the gradient (w, 4) of every window's sum of squares by its state, and its Gauss-Newton
    matrix (w, 4, 4), which can be solved with."""
    xt = lin.states_jac.transpose(0, 2, 1)
    H = xt @ lin.states_jac
    floor = np.maximum(1e-12 * np.einsum("wii->wi", H).max(axis=1), 1e-300)
    return (xt @ lin.r[:, :, None])[..., 0], H + floor[:, None, None] * np.eye(4)


def state_steps(lin: Linearisation, damping: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Damped steps of the states (w, 4), and what the full ones promise (w,)."""
    g, H = state_equations(lin)
    full = np.linalg.solve(H, g[..., None])[..., 0]
    diagonal = np.einsum("wii->wi", H)
    damped = H + (damping[:, None] * diagonal)[:, :, None] * np.eye(4)
    step = -np.linalg.solve(damped, g[..., None])[..., 0]
    return step, np.einsum("wi,wi->w", g, full)


def steps_along_kinks(lin: Linearisation, beyond: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Steps of the states (w, 4) down on both sides of a kink, and what they promise (w,).

    Args:
        lin: where the states are.
        beyond: (w, 4) half the gradients on the kinks' other sides; as here where there is none.
    """
    g, H = state_equations(lin)
    both = np.linalg.solve(H, np.stack([g, beyond], axis=-1))
    there, back = both[..., 0], both[..., 0] - both[..., 1]
    across = np.einsum("wi,wi->w", g - beyond, back)
    share = np.einsum("wi,wi->w", g, back) / np.maximum(across, 1e-300)
    share = np.clip(share, 0.0, 1.0)[:, None]
    mean, step = g - share * (g - beyond), there - share * back
    return -step, np.einsum("wi,wi->w", mean, step)


def warm_start_states(before: Fit, problem: Problem) -> np.ndarray:
    """Window states for a new cut, read off the trajectories of the last one."""
    states = problem.initial_states(before.values)
    old, new = before.problem.windows, problem.windows
    for i in range(new.n):
        same = np.flatnonzero(
            (old.recording == new.recording[i])
            & (old.first <= new.first[i])
            & (new.first[i] < old.first + old.count)
        )
        if same.size:
            j = same[0]
            states[i] = before.linearisation.states[j, new.first[i] - old.first[j], :4]
    return states
