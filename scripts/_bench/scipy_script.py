"""Identification as a good engineer would write it: SciPy's searches on free runs by CVODES.

Whole recordings are integrated from their first readings; the unknowns are logarithms of the
parameters, and CVODES' forward sensitivities are the Jacobian. It knows nothing of `tp_jax`.
"""

from typing import NamedTuple

import casadi as ca
import numpy as np
from scipy import optimize
from scipy.stats import qmc

from .peers.casadi_cvodes import integrator
from .problem import NAMES, SEARCHED

PLACES = [NAMES.index(name) for name in SEARCHED]
MOST_STEPS = 5000  # from one sample to the next: numbers that need more are nobody's
FAILED = 1e6  # residual in standard deviations where a run could not be integrated
EVALUATIONS = 200  # of a least-squares search


class Runs(NamedTuple):
    """Recordings with common times.

    ts (n,) [s]; readings (R, n, 2) [rad]; states (R, 4) at the first sample; omega (R,) of the
    drive [rad/s], 0 where there is none; B1 [kg m^2]; noise [rad]; eps [s]; tol: of CVODES.
    """

    ts: np.ndarray
    readings: np.ndarray
    states: np.ndarray
    omega: np.ndarray
    B1: float
    noise: float
    eps: float
    tol: float

    def row(self, values: np.ndarray, run: int) -> np.ndarray:
        """Returns what the integrator takes for a run."""
        p = np.zeros(len(NAMES) + 1)
        p[PLACES] = values
        p[NAMES.index("B1")], p[NAMES.index("omega")], p[-1] = self.B1, self.omega[run], self.eps
        if not self.omega[run]:
            p[NAMES.index("A")] = 0.0
        return p


def _integrator(runs: Runs, directions: int) -> ca.Function:
    return integrator(runs.ts.tobytes(), runs.tol, directions, most=MOST_STEPS)


def angles(runs: Runs, values: np.ndarray) -> np.ndarray:
    """Angles (R, n, 2) of free runs; NaN where one fails."""
    solve = _integrator(runs, 0)
    out = np.full(runs.readings.shape, np.nan)
    for r, state in enumerate(runs.states):
        try:
            out[r] = solve(x0=state, p=runs.row(values, r))["xf"].full()[:2].T
        except RuntimeError:  # CVODES gave up
            break
    return out


def residuals(x: np.ndarray, runs: Runs) -> np.ndarray:
    """(2 R n,), in standard deviations of the noise."""
    found = ((angles(runs, np.exp(x)) - runs.readings) / runs.noise).ravel()
    return found if np.isfinite(found).all() else np.full(found.size, FAILED)


def jacobian(x: np.ndarray, runs: Runs) -> np.ndarray:
    """Derivatives (2 R n, u) of the residuals."""
    values, u = np.exp(x), len(SEARCHED)
    solve = _integrator(runs, u)
    out = np.zeros((*runs.readings.shape, u))
    for r, state in enumerate(runs.states):
        x0, p = np.zeros((4, 1 + u)), np.zeros((len(NAMES) + 1, 1 + u))
        x0[:, 0], p[:, 0] = state, runs.row(values, r)
        p[PLACES, 1 + np.arange(u)] = values
        if not runs.omega[r]:
            p[NAMES.index("A"), 1:] = 0.0
        try:
            blocks = solve(x0=x0, p=p)["xf"].full()[:2]
        except RuntimeError:
            continue
        out[r] = blocks.reshape(2, runs.ts.size, 1 + u)[:, :, 1:].swapaxes(0, 1)
    return np.nan_to_num(out).reshape(-1, u) / runs.noise


def starts(number: int, lower: np.ndarray, upper: np.ndarray, seed: int) -> np.ndarray:
    """Points (number, u) spread over the logarithms of bounds: a Latin hypercube."""
    share = qmc.LatinHypercube(len(lower), rng=seed).random(number)
    return np.log(lower) + share * np.log(upper / lower)


def fit(x0: np.ndarray, runs: Runs, lower: np.ndarray, upper: np.ndarray) -> tuple:
    """Finds where least squares from a start end: logarithms (u,), sum of squares, evaluations."""
    found = optimize.least_squares(
        residuals,
        x0,
        jacobian,
        bounds=(np.log(lower), np.log(upper)),
        x_scale="jac",
        max_nfev=EVALUATIONS,
        args=(runs,),
    )
    return found.x, 2.0 * float(found.cost), int(found.nfev)


def objective(values: np.ndarray, runs: Runs) -> float:
    """(17) as a mean over the runs [rad^2]; infinite where one fails."""
    squares = (angles(runs, values) - runs.readings) ** 2
    y = float(squares.mean())
    return y if np.isfinite(y) else np.inf


def simplex_search(
    x0: np.ndarray, runs: Runs, limits: tuple[np.ndarray, np.ndarray], iterations: int
) -> tuple[np.ndarray, float, int]:
    """SciPy's Nelder-Mead on `objective` in coordinates that begin at one.

    Returns:
        Values (u,), the objective there, evaluations.
    """
    clipped = lambda u: np.clip(x0 * u, *limits)  # noqa: E731
    found = optimize.minimize(
        lambda u: objective(clipped(u), runs),
        np.ones(len(x0)),
        method="Nelder-Mead",
        options={"maxiter": iterations, "maxfev": np.inf, "xatol": 1e-4, "fatol": 1e-4},
    )
    return clipped(found.x), float(found.fun), int(found.nfev)
