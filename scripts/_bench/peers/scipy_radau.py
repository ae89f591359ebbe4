"""SciPy's Radau IIA, implicit of order 5."""

import numpy as np
from scipy.integrate import solve_ivp

from ..equations import constants, jacobian, rates
from ..peer import Peer, cores
from ..pool import sweep_of


def run(parameters, eps, ts, tol):
    """Angles (n, 2) of one run."""
    c = constants(parameters, eps)
    solution = solve_ivp(
        lambda t, y: rates(t, y, c),
        (ts[0], ts[-1]),
        np.zeros(4),
        "Radau",
        t_eval=ts,
        jac=lambda t, y: jacobian(t, y, c),
        rtol=tol,
        atol=tol,
    )
    return solution.y[:2].T if solution.success else np.full((ts.size, 2), np.nan)


def make() -> Peer:
    """The peer."""
    return Peer("scipy-radau", run, sweep_of(__name__), threads=cores())
