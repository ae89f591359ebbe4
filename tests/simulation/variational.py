"""Derivatives of a motion by its variational equations, integrated by SciPy.

With S = dy/dx for the initial state and some numbers x, `S' = J S + f_x`; J and f_x by the complex
step from formulas written anew, so that nothing of the package is in here.
"""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from scipy.integrate import odeint

TINY = 1e-30


def sign(v):
    return np.where(v.real < 0.0, -1.0, 1.0)


def double(t: float, y: np.ndarray, p: Mapping) -> np.ndarray:
    """Equations (3b), (5), (6) without Ts2, and (16), for complex numbers too."""
    phi1, _, v1, v2 = y
    ML = p["c1"] * v1 + p["M1"] * (2.0 / np.pi) * np.arctan(p["eps"] * v1)
    MT = p["Tv"] * v2 + p["Ts1"] * (2.0 / np.pi) * np.arctan(p["eps"] * v2)
    MT = MT + p["Tst"] * (1.0 - np.exp(-p["T0"] * sign(v2) * v2)) * sign(v2)
    f = p["A"] * np.sin(p["omega"] * t)
    a1 = (p["k"] * (f - phi1) - ML + p["reaction"] * MT) / p["B1"]
    return np.stack([v1, v2, a1, -MT / p["B2"] - a1])


def single_with_bristle(t: float, y: np.ndarray, p: Mapping) -> np.ndarray:
    """The column alone; a part a of its dry friction follows z' = v1 - |v1| z/z0."""
    phi1, _, v1, v2, z = y
    dry = (1.0 - p["a"]) * (2.0 / np.pi) * np.arctan(p["eps"] * v1) + p["a"] * z / p["z0"]
    f = p["A"] * np.sin(p["omega"] * t)
    a1 = (p["k"] * (f - phi1) - p["c1"] * v1 - p["M1"] * dry) / p["B1"]
    return np.stack([v1, 0.0 * v2, a1, 0.0 * v2, v1 - sign(v1) * v1 * z / p["z0"]])


def variational(
    field: Callable, p: Mapping[str, float], names: Sequence[str], ts: np.ndarray, y0: Sequence
) -> tuple[np.ndarray, np.ndarray]:
    """Motion (n, c), and its derivatives (n, c, c + names) by the initial state and by `names`."""
    c = len(y0)
    nd = c + len(names)
    bump = np.zeros((c, nd), complex)
    bump[:, :c] = 1j * TINY * np.eye(c)
    q = dict(p)
    for i, name in enumerate(names):
        q[name] = q[name] + 1j * TINY * (np.arange(nd) == c + i)

    def slopes(t, y):
        d = field(t, y[:, None] + bump, q)
        return d[:, 0].real, d.imag / TINY

    def right_hand_side(t, z):
        z = z.reshape(1 + nd, c)
        f, d = slopes(t, z[0])
        change = z[1:] @ d[:, :c].T
        change[c:] += d[:, c:].T
        return np.concatenate([f[None], change]).ravel()

    def band(t, z):
        # the motion and all directions side by side; what couples them is left to the iteration
        _, d = slopes(t, z[:c])
        rows = np.zeros((2 * c - 1, (1 + nd) * c))
        for i in range(c):
            for j in range(c):
                rows[c - 1 + i - j, j::c] = d[i, j]
        return rows

    start = np.concatenate([np.asarray(y0, float)[None], np.eye(nd, c)]).ravel()
    z = odeint(
        right_hand_side,
        start,
        ts,
        tfirst=True,
        Dfun=band,
        ml=c - 1,
        mu=c - 1,
        rtol=1e-10,
        atol=1e-11,
        mxstep=1_000_000,
        hmax=0.01,
    ).reshape(len(ts), 1 + nd, c)
    return z[:, 0], z[:, 1:].transpose(0, 2, 1)
