"""CasADi's CVODES (BDF), with forward sensitivities, on an SX graph.

Measured and left out, since no faster here: `map` on threads, code generated and compiled, other
linear solvers. `second_order_correction` off halves the cost of the sensitivities at equal error.
"""

from functools import lru_cache

import casadi as ca
import numpy as np

from ..equations import TWO_OVER_PI
from ..peer import Peer, cores
from ..pool import sweep_of
from ..problem import DIRECTIONS, VARIED


def equations() -> dict:
    """The problem as CasADi wants it; `p` is a row of parameters and eps."""
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x", 4), ca.SX.sym("p", 12)
    k, A, B1, B2, c1, M1, Tv, Ts1, Tst, T0, omega, eps = ca.vertsplit(p)
    q1, _, v1, v2 = ca.vertsplit(x)
    contact = Tv * v2 + TWO_OVER_PI * Ts1 * ca.atan(eps * v2)
    contact -= Tst * ca.expm1(-T0 * ca.fabs(v2)) * ca.sign(v2)
    bearing = c1 * v1 + TWO_OVER_PI * M1 * ca.atan(eps * v1)
    a1 = (k * (A * ca.sin(omega * t) - q1) - bearing + contact) / B1
    return {"t": t, "x": x, "p": p, "ode": ca.vertcat(v1, v2, a1, -contact / B2 - a1)}


@lru_cache(maxsize=8)
def integrator(
    grid: bytes, tol: float, directions: int, method: str = "bdf", most: int = 2_000_000_000
) -> ca.Function:
    """An integrator over the grid of output times; building one takes a few milliseconds.

    most: steps from one output time to the next.
    """
    ts = np.frombuffer(grid)
    options = {
        "reltol": tol,
        "abstol": tol,
        "max_num_steps": most,
        "nfwd": directions,
        "linear_multistep_method": method,
        "second_order_correction": False,
        "disable_internal_warnings": True,
        "show_eval_warnings": False,
    }
    return ca.integrator("run", "cvodes", equations(), ts[0], ts.tolist(), options)


def run(parameters, eps, ts, tol, method="bdf"):
    """Angles (n, 2) of one run."""
    solve = integrator(ts.tobytes(), float(tol), 0, method)
    try:
        states = solve(x0=np.zeros(4), p=np.append(parameters, eps))["xf"]
    except RuntimeError:  # CVODES gave up
        return np.full((ts.size, 2), np.nan)
    return states.full()[:2].T


def sensitivities(parameters, eps, ts, tol, method="bdf"):
    """Derivatives (n, 2, 14) of the angles, all directions in one integration."""
    n = len(DIRECTIONS)
    solve = integrator(ts.tobytes(), float(tol), n, method)
    # first columns are values, the others seeds
    x0, p = np.zeros((4, 1 + n)), np.zeros((12, 1 + n))
    x0[:, 1 + len(VARIED) :] = np.eye(4)
    p[:, 0] = np.append(parameters, eps)
    p[: len(VARIED), 1 : 1 + len(VARIED)] = np.eye(len(VARIED))
    try:
        blocks = solve(x0=x0, p=p)["xf"].full()[:2]
    except RuntimeError:
        return np.full((ts.size, 2, n), np.nan)
    return blocks.reshape(2, ts.size, 1 + n)[:, :, 1:].swapaxes(0, 1)


def make() -> Peer:
    """The peer."""
    return Peer("casadi-cvodes", run, sweep_of(__name__), sensitivities, threads=cores())
