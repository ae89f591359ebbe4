"""CasADi's CVODES with Adams' formulas instead of BDF: fewer steps where nothing sticks."""

from ..peer import Peer, cores
from ..pool import sweep_of
from . import casadi_cvodes


def run(parameters, eps, ts, tol):
    """Angles (n, 2) of one run."""
    return casadi_cvodes.run(parameters, eps, ts, tol, "adams")


def sensitivities(parameters, eps, ts, tol):
    """Derivatives (n, 2, 14) of the angles."""
    return casadi_cvodes.sensitivities(parameters, eps, ts, tol, "adams")


def make() -> Peer:
    """The peer."""
    return Peer("casadi-adams", run, sweep_of(__name__), sensitivities, threads=cores())
