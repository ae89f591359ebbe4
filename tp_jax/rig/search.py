"""Finding the events within a step: that there is one, and the step that ends at it."""

from collections.abc import Callable

from tp_jax.rig.stepper import End

SHORTEST = 1e-12  # s: a step below it is none
STILL = 1e-11  # rad/s: slower is at rest, far below what a step is in error by
ZERO = 1e-14  # rad/s, N m or rad: where the search ends
TRIES = 60


def locate(
    gap: Callable[[End], float], trial: Callable[[float], End], start: End, end: End
) -> End | None:
    """The step up to where a gap falls to zero; None if it does not within `end`.

    By the Illinois variant of the secant method, on steps taken anew.

    Args:
        gap: falls through zero at the event. trial: a step of a length [s].
        start: the step of no length. end: a step by which the gap may have fallen.
    """
    right, fr = end, gap(end)
    if fr >= 0.0:
        return None
    left, fl = start, gap(start)
    if fl <= 0.0:
        # it may have risen first, as of a body that has only just let go
        risen = _risen(gap, trial, end.h)
        if risen is None:
            return start
        left, fl = risen
    kept = 0
    for _ in range(TRIES):
        width = right.h - left.h
        if width <= SHORTEST:
            break
        x = left.h + width * fl / (fl - fr)
        if not left.h < x < right.h:
            x = 0.5 * (left.h + right.h)
        best = trial(x)
        f = gap(best)
        if abs(f) <= ZERO:
            return best
        if f > 0.0:
            left, fl = best, f
            if kept > 0:
                fr *= 0.5
            kept = 1
        else:
            right, fr = best, f
            if kept < 0:
                fl *= 0.5
            kept = -1
    return right


def _risen(
    gap: Callable[[End], float], trial: Callable[[float], End], h: float
) -> tuple[End, float] | None:
    """A shorter step at whose end the gap is above zero."""
    for _ in range(30):
        h *= 0.5
        end = trial(h)
        f = gap(end)
        if f > 0.0:
            return end, f
    return None


def stops(h: float, side: int, v0: float, a0: float, v1: float, a1: float) -> bool:
    """True if a sliding may end within a step; it may pass zero and come back."""
    begun = side * v0 > 0.0
    if side * v1 < 0.0:
        # a body that has only just let go may seem to go back, by rounding
        return begun or side * v1 < -STILL
    if not begun or side * a0 >= 0.0 or side * a1 <= 0.0:
        return False
    # steep enough to have passed zero before it turned
    return side * v1 < max(-side * a0, side * a1) * h


def lowest(h: float, v0: float, a0: float, v1: float, a1: float) -> float:
    """Finds where in a step a quantity that falls at its start and rises at its end is lowest.

    By the cubic through value and slope at both ends; the length from the start.
    """
    rise = v1 - v0 - a0 * h
    turn = (a1 - a0) * h
    c2, c3 = 3.0 * rise - turn, turn - 2.0 * rise
    # slope a0 h + 2 c2 x + 3 c3 x^2 = 0, the root that is stable for small c3
    root = max(c2 * c2 - 3.0 * c3 * a0 * h, 0.0) ** 0.5
    below = c2 + root
    x = -a0 * h / below if below > 0.0 else 0.5
    return h * min(max(x, 0.0), 1.0)
