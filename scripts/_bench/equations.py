"""The double torsion pendulum in plain numbers, compiled by Numba where that is installed.

Shared by all peers that take a function; nothing of `tp_jax` is used, so that an error in its
equations would show as an error of its angles.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

try:
    import numba
except ImportError:
    numba = None

#: Reassociation and fused products, but NaN and infinity stay what they are: the step size control
#: has to see them.
FAST = {"reassoc", "contract", "arcp", "nsz", "afn"}
TWO_OVER_PI = 2.0 / math.pi


def compiled(function: Callable[..., Any] | None = None, **options: Any) -> Callable[..., Any]:
    """`numba.njit`, kept on disk; without Numba the function as it is."""
    if function is None:
        return lambda f: compiled(f, **options)
    if numba is None:
        return function
    return numba.njit(cache=True, **{"error_model": "numpy", **options})(function)


@compiled(fastmath=FAST)
def constants(p, eps):
    """Computes what the equations need of a row of parameters, divisions done beforehand."""
    return (
        p[0],
        p[1],
        1.0 / p[2],
        1.0 / p[3],
        p[4],
        TWO_OVER_PI * p[5],
        p[6],
        TWO_OVER_PI * p[7],
        p[8],
        p[9],
        p[10],
        eps,
    )


@compiled(fastmath=FAST)
def accelerations(t, q1, v1, v2, c):
    """v1', v2' by (16) with the reaction 1 of Newton's third law; Ts2 acts at no instant."""
    k, A, b1, b2, c1, m1, tv, ts1, tst, t0, omega, eps = c
    rising = tst * (1.0 - math.exp(-t0 * abs(v2)))
    contact = tv * v2 + ts1 * math.atan(eps * v2) + math.copysign(rising, v2)
    bearing = c1 * v1 + m1 * math.atan(eps * v1)
    a1 = (k * (A * math.sin(omega * t) - q1) - bearing + contact) * b1
    return a1, -contact * b2 - a1


@compiled(fastmath=FAST)
def slopes(v1, v2, c):
    """Derivatives of the two accelerations by v1 and by v2: a11, a12, a21, a22."""
    _, _, b1, b2, c1, m1, tv, ts1, tst, t0, _, eps = c
    x1, x2 = eps * v1, eps * v2
    bearing = c1 + m1 * eps / (1.0 + x1 * x1)
    contact = tv + ts1 * eps / (1.0 + x2 * x2) + tst * t0 * math.exp(-t0 * abs(v2))
    return -bearing * b1, contact * b1, bearing * b1, -contact * (b1 + b2)


@compiled
def fill_rates(t, y, out, c):
    """Right-hand side (4,) into `out`."""
    a1, a2 = accelerations(t, y[0], y[2], y[3], c)
    out[0], out[1], out[2], out[3] = y[2], y[3], a1, a2


@compiled
def rates(t, y, c):
    """Right-hand side (4,) as a new array."""
    out = np.empty(4)
    fill_rates(t, y, out, c)
    return out


@compiled
def fill_jacobian(y, out, c):
    """Jacobian (4, 4) into `out`."""
    out[:] = 0.0
    out[0, 2] = out[1, 3] = 1.0
    out[2, 0], out[3, 0] = -c[0] * c[2], c[0] * c[2]
    out[2, 2], out[2, 3], out[3, 2], out[3, 3] = slopes(y[2], y[3], c)


@compiled
def jacobian(t, y, c):  # noqa: ARG001
    """Jacobian (4, 4) as a new array."""
    out = np.empty((4, 4))
    fill_jacobian(y, out, c)
    return out
