"""The rig without effects written anew: SciPy's DOP853 from switch to switch.

Each mode (side of column, side of rider; 0 for rest) is integrated until SciPy locates an event;
what follows is whichever of the nine modes is consistent, found by trying all of them.
"""

import itertools
import math

import numpy as np
from scipy.integrate import solve_ivp

from tp_jax.rig import RigParameters


def accelerations(p: RigParameters, omega, t, y, mode):
    """a1, a2 and the dry torques F1, D2 in a mode, from a linear system in these four."""
    phi1, _, v1, v2 = y
    f = 0.0 if omega is None else p.A * math.sin(omega * t)
    free = p.k * (f - phi1) - p.c1 * v1
    # unknowns a1, a2, F1, D2; contact torque MT = Tv v2 + D2
    A = np.zeros((4, 4))
    b = np.zeros(4)
    A[0] = [p.B1, 0.0, 1.0, -1.0]
    b[0] = free + p.Tv * v2
    A[1] = [p.B2, p.B2, 0.0, 1.0]
    b[1] = -p.Tv * v2
    dry2 = p.Ts1 + p.Tst * (1.0 - math.exp(-p.T0 * abs(v2)))
    for row, side, limit, a, force in ((2, mode[0], p.M1, 0, 2), (3, mode[1], dry2, 1, 3)):
        if side:
            A[row, force], b[row] = 1.0, side * limit
        else:
            A[row, a] = 1.0
    return np.linalg.solve(A, b)


def consistent(p: RigParameters, omega, t, y, margin: float = 1e-9):
    """The modes that contradict nothing, `margin` [N m] allowed."""
    found = []
    for mode in itertools.product((-1, 0, 1), repeat=2):
        if any(v != 0.0 and side != np.sign(v) for side, v in zip(mode, y[2:], strict=True)):
            continue
        a1, a2, F1, D2 = accelerations(p, omega, t, y, mode)
        fits = [
            abs(force) <= limit + margin if side == 0 else v != 0.0 or side * a * p.B2 >= -margin
            for side, v, a, force, limit in zip(
                mode, y[2:], (a1, a2), (F1, D2), (p.M1, p.Ts1), strict=True
            )
        ]
        if all(fits):
            found.append(mode)
    return found


def by_events(p: RigParameters, ts: np.ndarray, omega=None, release: float = 0.0) -> np.ndarray:
    """phi1, phi2 (n, 2) [rad] at `ts`."""
    t, y, end = 0.0, np.array([release, 0.0, 0.0, 0.0]), float(ts[-1])
    out = np.full((ts.size, 2), np.nan)
    mode = consistent(p, omega, t, y)[0]
    while t < end:

        def rhs(t, y, mode=mode):
            a1, a2, _, _ = accelerations(p, omega, t, y, mode)
            return [y[2], y[3], a1, a2]

        events = [
            (lambda t, y, i=i, mode=mode: y[2 + i])
            if mode[i]
            else (
                lambda t, y, i=i, mode=mode: (
                    abs(accelerations(p, omega, t, y, mode)[2 + i]) - (p.M1, p.Ts1)[i]
                )
            )
            for i in (0, 1)
        ]
        for event, side in zip(events, mode, strict=True):
            event.terminal, event.direction = True, -side if side else 1
        run = solve_ivp(
            rhs,
            (t, end),
            y,
            "DOP853",
            events=events,
            rtol=1e-12,
            atol=1e-14,
            dense_output=True,
            max_step=0.01,
        )
        inside = (ts >= t) & (ts <= run.t[-1])
        if inside.any():
            out[inside] = run.sol(ts[inside])[:2].T
        t, y = float(run.t[-1]), run.y[:, -1].copy()
        if run.status == 0:
            break
        i = 0 if run.t_events[0].size else 1
        old = mode
        if mode[i]:
            y[2 + i] = 0.0
            mode = consistent(p, omega, t, y)[0]
        else:
            force = accelerations(p, omega, t, y, mode)[2 + i]
            choices = [m for m in consistent(p, omega, t, y, 1e-8) if m[i] == int(np.sign(force))]
            mode = choices[0]
        assert mode != old
    return out
