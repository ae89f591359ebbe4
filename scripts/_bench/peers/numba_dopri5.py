"""Dormand and Prince's 5(4) by hand in Numba: what a user who wants speed would write.

Everything in registers: no array but the samples. First same as last, PI step size control, the
method's own interpolant of order 4 at the samples, as in DOPRI5 of Hairer, Nørsett, Wanner,
"Solving Ordinary Differential Equations I". Runs of a sweep are shared out among threads.
"""

import numba
import numpy as np

from ..equations import FAST, accelerations, constants
from ..peer import Peer, cores
from ._numba_tangents import sensitivities

MAX_STEPS = 1_000_000_000  # far above what the cap on a call allows


@numba.njit(fastmath=FAST, cache=True, error_model="numpy")
def integrate(p, eps, ts, tol, out):
    """One run from rest: angles into `out` (n, 2), NaN where it failed; returns the steps."""
    c = constants(p, eps)
    n, end = ts.size, ts[-1]
    out[:] = np.nan
    t, q1, q2, v1, v2 = ts[0], 0.0, 0.0, 0.0, 0.0
    a1, a2 = accelerations(t, q1, v1, v2, c)
    out[0, 0], out[0, 1] = q1, q2
    sample, steps, h, last_error = 1, 0, 1e-6, 1e-4
    while sample < n and steps < MAX_STEPS:
        steps += 1
        h = min(h, end - t)
        # stages; a position's rate is a velocity, so that only two of four need the equations
        w1, w2 = v1 + h * 0.2 * a1, v2 + h * 0.2 * a2
        b1, b2 = accelerations(t + 0.2 * h, q1 + h * 0.2 * v1, w1, w2, c)

        x1, x2 = v1 + h * (3 / 40 * a1 + 9 / 40 * b1), v2 + h * (3 / 40 * a2 + 9 / 40 * b2)
        r = q1 + h * (3 / 40 * v1 + 9 / 40 * w1)
        d1, d2 = accelerations(t + 0.3 * h, r, x1, x2, c)

        y1 = v1 + h * (44 / 45 * a1 - 56 / 15 * b1 + 32 / 9 * d1)
        y2 = v2 + h * (44 / 45 * a2 - 56 / 15 * b2 + 32 / 9 * d2)
        r = q1 + h * (44 / 45 * v1 - 56 / 15 * w1 + 32 / 9 * x1)
        e1, e2 = accelerations(t + 0.8 * h, r, y1, y2, c)

        z1 = v1 + h * (19372 / 6561 * a1 - 25360 / 2187 * b1 + 64448 / 6561 * d1 - 212 / 729 * e1)
        z2 = v2 + h * (19372 / 6561 * a2 - 25360 / 2187 * b2 + 64448 / 6561 * d2 - 212 / 729 * e2)
        r = q1 + h * (19372 / 6561 * v1 - 25360 / 2187 * w1 + 64448 / 6561 * x1 - 212 / 729 * y1)
        f1, f2 = accelerations(t + 8 / 9 * h, r, z1, z2, c)

        u1 = v1 + h * (
            9017 / 3168 * a1 - 355 / 33 * b1 + 46732 / 5247 * d1 + 49 / 176 * e1 - 5103 / 18656 * f1
        )
        u2 = v2 + h * (
            9017 / 3168 * a2 - 355 / 33 * b2 + 46732 / 5247 * d2 + 49 / 176 * e2 - 5103 / 18656 * f2
        )
        r = q1 + h * (
            9017 / 3168 * v1 - 355 / 33 * w1 + 46732 / 5247 * x1 + 49 / 176 * y1 - 5103 / 18656 * z1
        )
        g1, g2 = accelerations(t + h, r, u1, u2, c)

        n1 = v1 + h * weighted(a1, d1, e1, f1, g1)
        n2 = v2 + h * weighted(a2, d2, e2, f2, g2)
        s1 = q1 + h * weighted(v1, x1, y1, z1, u1)
        s2 = q2 + h * weighted(v2, x2, y2, z2, u2)
        m1, m2 = accelerations(t + h, s1, n1, n2, c)

        error = scaled(q1, s1, h * defect(v1, x1, y1, z1, u1, n1), tol)
        error += scaled(q2, s2, h * defect(v2, x2, y2, z2, u2, n2), tol)
        error += scaled(v1, n1, h * defect(a1, d1, e1, f1, g1, m1), tol)
        error += scaled(v2, n2, h * defect(a2, d2, e2, f2, g2, m2), tol)
        error = np.sqrt(0.25 * error)
        if not error < 1e300:  # infinite or NaN
            h *= 0.1
            if h < 1e-15:
                return steps
            continue
        growth = max(error, 1e-10) ** 0.17
        if error > 1.0:
            h /= min(5.0, growth / 0.9)
            continue
        new = t + h
        # the last sample must not wait for a sliver of a step
        reach = new if end - new > 1e-12 else end + 1.0
        while sample < n and ts[sample] <= reach:
            x = (ts[sample] - t) / h
            out[sample, 0] = between(x, q1, s1, h, v1, n1, dense(v1, x1, y1, z1, u1, n1))
            out[sample, 1] = between(x, q2, s2, h, v2, n2, dense(v2, x2, y2, z2, u2, n2))
            sample += 1
        t, q1, q2, v1, v2, a1, a2 = new, s1, s2, n1, n2, m1, m2
        h /= min(5.0, max(0.1, growth / last_error**0.04 / 0.9))
        last_error = max(error, 1e-4)
    return steps


@numba.njit(fastmath=FAST, cache=True, error_model="numpy", inline="always")
def weighted(k1, k3, k4, k5, k6):
    """Increment of order 5, over h."""
    return 35 / 384 * k1 + 500 / 1113 * k3 + 125 / 192 * k4 - 2187 / 6784 * k5 + 11 / 84 * k6


@numba.njit(fastmath=FAST, cache=True, error_model="numpy", inline="always")
def defect(k1, k3, k4, k5, k6, k7):
    """Difference of orders 5 and 4, over h."""
    first = 71 / 57600 * k1 - 71 / 16695 * k3 + 71 / 1920 * k4
    return first - 17253 / 339200 * k5 + 22 / 525 * k6 - 1 / 40 * k7


@numba.njit(fastmath=FAST, cache=True, error_model="numpy", inline="always")
def dense(k1, k3, k4, k5, k6, k7):
    """Last coefficient of the interpolant, over h."""
    first = -12715105075 / 11282082432 * k1 + 87487479700 / 32700410799 * k3
    second = -10690763975 / 1880347072 * k4 + 701980252875 / 199316789632 * k5
    return first + second - 1453857185 / 822651844 * k6 + 69997945 / 29380423 * k7


@numba.njit(fastmath=FAST, cache=True, error_model="numpy", inline="always")
def between(x, y0, y1, h, k1, k7, last):
    """The interpolant at the fraction x of a step."""
    difference = y1 - y0
    bump = h * k1 - difference
    third = difference - h * k7 - bump
    return y0 + x * (difference + (1.0 - x) * (bump + x * (third + (1.0 - x) * h * last)))


@numba.njit(fastmath=FAST, cache=True, error_model="numpy", inline="always")
def scaled(y0, y1, difference, tol):
    """Square of an error over what is allowed."""
    ratio = difference / (tol * (1.0 + max(abs(y0), abs(y1))))
    return ratio * ratio


@numba.njit(cache=True, parallel=True)
def integrate_all(table, eps, ts, tol, out):
    """Runs of all rows, shared out among Numba's threads."""
    for i in numba.prange(table.shape[0]):
        integrate(table[i], eps, ts, tol, out[i])


def run(parameters, eps, ts, tol):
    """Angles (n, 2) of one run."""
    out = np.empty((ts.size, 2))
    integrate(parameters, eps, ts, tol, out)
    return out


def sweep(table, eps, ts, tol):
    """Angles (lanes, n, 2)."""
    out = np.empty((len(table), ts.size, 2))
    # small chunks, since runs differ in length
    with numba.parallel_chunksize(4):
        integrate_all(table, eps, ts, tol, out)
    return out


def make() -> Peer:
    """The peer."""
    return Peer("numba-dopri5", run, sweep, sensitivities, threads=cores())
