"""The variational equations: how the motion changes with ten parameters and four initial states.

Integrated beside the motion itself, in relative changes of the parameters, so that all derivatives
are of like size. What one writes by hand where no tool differentiates.
"""

import numpy as np
from scipy.integrate import odeint

from .equations import FAST, accelerations, compiled, constants, slopes
from .problem import DIRECTIONS, VARIED

STATES = 4 * (1 + len(DIRECTIONS))


def start() -> np.ndarray:
    """States (60,) at rest, and their derivatives there."""
    states = np.zeros((1 + len(DIRECTIONS), 4))
    states[1 + len(VARIED) :] = np.eye(4)
    return states.ravel()


def derivatives(states: np.ndarray, row: np.ndarray) -> np.ndarray:
    """Derivatives (n, 2, 14) of the angles, by the parameters as they are, from states (n, 60)."""
    tangents = states.reshape(len(states), -1, 4)[:, 1:, :2].copy()
    tangents[:, : len(VARIED)] /= row[: len(VARIED), None]
    return tangents.swapaxes(1, 2)


def by_lsoda(row: np.ndarray, eps: float, ts: np.ndarray, tol: float) -> np.ndarray:
    """Derivatives (n, 2, 14) of the angles, the tolerance held for them too."""
    states = odeint(
        variations,
        start(),
        ts,
        args=(constants(row, eps),),
        tfirst=True,
        rtol=tol,
        atol=tol,
        mxstep=100_000_000,
    )
    return derivatives(states, row)


@compiled
def variations(t, y, c):
    """`fill_variations` as a new array."""
    out = np.empty(60)
    fill_variations(t, y, c, out)
    return out


@compiled(fastmath=FAST)
def fill_variations(t, y, c, out):
    """Rates (60,) of the four states, and of their derivatives in fourteen directions."""
    q1, v1, v2 = y[0], y[2], y[3]
    a1, a2 = accelerations(t, q1, v1, v2, c)
    out[0], out[1], out[2], out[3] = v1, v2, a1, a2
    a11, a12, a21, a22 = slopes(v1, v2, c)
    spring = c[0] * c[2]
    sine = np.sin(c[10] * t)
    fade = np.exp(-c[9] * abs(v2))
    # p d/dp of the torque between the bodies: Tv, Ts1, Tst, T0
    torques = (
        c[6] * v2,
        c[7] * np.arctan(c[11] * v2),
        np.copysign(c[8] * (1.0 - fade), v2),
        c[8] * c[9] * v2 * fade,
    )
    contact = torques[0] + torques[1] + torques[2]
    # p d/dp of the column's torque: k, A, B1, -, c1, M1
    column = (
        c[0] * (c[1] * sine - q1),
        c[0] * c[1] * sine,
        -a1 / c[2],
        0.0,
        -c[4] * v1,
        -c[5] * np.arctan(c[11] * v1),
    )
    for i in range(14):
        j = 4 * (i + 1)
        d1 = -spring * y[j] + a11 * y[j + 2] + a12 * y[j + 3]
        d2 = spring * y[j] + a21 * y[j + 2] + a22 * y[j + 3]
        if i < 6:
            d1 += column[i] * c[2]
            d2 -= column[i] * c[2]
        elif i < 10:
            d1 += torques[i - 6] * c[2]
            d2 -= torques[i - 6] * (c[2] + c[3])
        if i == 3:
            d2 += contact * c[3]
        out[j], out[j + 1], out[j + 2], out[j + 3] = y[j + 2], y[j + 3], d1, d2
