"""SciPy's LSODA through `odeint`, whose loop over the samples is not in Python.

Its sensitivities are the variational equations, written by hand.
"""

import warnings

import numpy as np
from scipy.integrate import odeint

from ..equations import constants, jacobian, rates
from ..peer import Peer, cores
from ..pool import sweep_of
from ..variational import by_lsoda


def integrate(parameters, eps, ts, tol):
    """States (n, 4), NaN where it failed."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # what it warns of is in its message too
        states, report = odeint(
            rates,
            np.zeros(4),
            ts,
            args=(constants(parameters, eps),),
            Dfun=jacobian,
            tfirst=True,
            rtol=tol,
            atol=tol,
            mxstep=100_000_000,
            full_output=True,
        )
    return states if report["message"].startswith("Integration successful") else states * np.nan


def run(parameters, eps, ts, tol):
    """Angles (n, 2) of one run."""
    return integrate(parameters, eps, ts, tol)[:, :2]


def make() -> Peer:
    """The peer."""
    return Peer("scipy-lsoda", run, sweep_of(__name__), by_lsoda, threads=cores())
