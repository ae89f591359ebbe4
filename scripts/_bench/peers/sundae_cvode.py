"""scikit-sundae's CVODE (BDF), right-hand side and Jacobian compiled by Numba.

It calls both through Python, which is most of its cost; it has no other way.
"""

import numpy as np
import sksundae

from ..equations import compiled, constants, fill_jacobian, fill_rates
from ..peer import Peer, cores
from ..pool import sweep_of


@compiled
def right_hand_side(t, y, out, c):
    """Signature of scikit-sundae."""
    fill_rates(t, y, out, c)


@compiled
def derivative(t, y, rates, out, c):  # noqa: ARG001
    """Signature of scikit-sundae."""
    fill_jacobian(y, out, c)


def run(parameters, eps, ts, tol):
    """Angles (n, 2) of one run."""
    # building one takes microseconds
    solver = sksundae.cvode.CVODE(
        right_hand_side,
        jacfn=derivative,
        userdata=constants(parameters, eps),
        rtol=tol,
        atol=tol,
        max_num_steps=1_000_000_000,
    )
    solution = solver.solve(ts, np.zeros(4))
    return solution.y[:, :2] if solution.success else np.full((ts.size, 2), np.nan)


def make() -> Peer:
    """The peer."""
    return Peer("sundae-cvode", run, sweep_of(__name__), threads=cores())
