"""Losses that do not let a few outlying samples decide.

The sum of rho(r^2) is again a sum of squares, of r sqrt(rho(r^2) / r^2); so every method of least
squares serves, with residuals and Jacobian changed row by row.

Source: Huber (1964), Ann. Math. Stat. 35:73; tuning constants for 95 % efficiency on normal noise
from Holland and Welsch (1977), Commun. Stat. A6:813. Names as in `scipy.optimize.least_squares`.
"""

from types import ModuleType
from typing import Any, Literal, get_args

import numpy as np

from tp_jax.estimation.linearisation import Linearisation

Loss = Literal["linear", "huber", "soft-l1", "cauchy"]
LOSSES: tuple[str, ...] = get_args(Loss)

TUNING = {"huber": 1.345, "soft-l1": 1.345, "cauchy": 2.385}  # in standard deviations


def robustify(r: Any, loss: Loss, xp: ModuleType = np) -> tuple[Any, Any]:
    """Residuals whose squares sum to the loss, and the factors (...) of their derivatives.

    Args:
        r: (...) residuals in units of the noise.
        loss: which.
        xp: numpy, or jax.numpy.

    Example:
        >>> import numpy as np
        >>> changed, factor = robustify(np.array([0.5, 10.0]), "huber")
        >>> changed.round(3).tolist(), factor.round(3).tolist()
        ([0.5, 5.009], [1.0, 0.269])
    """
    if loss == "linear":
        return r, xp.ones_like(r)
    c2 = TUNING[loss] ** 2
    z = r**2 / c2
    safe = xp.where(z > 1e-8, z, 1.0)
    if loss == "huber":
        rho = xp.where(safe <= 1.0, safe, 2.0 * xp.sqrt(safe) - 1.0)
        slope = xp.where(safe <= 1.0, 1.0, 1.0 / xp.sqrt(safe))
    elif loss == "soft-l1":
        rho, slope = 2.0 * (xp.sqrt(1.0 + safe) - 1.0), 1.0 / xp.sqrt(1.0 + safe)
    else:
        rho, slope = xp.log1p(safe), 1.0 / (1.0 + safe)
    ratio = xp.where(z > 1e-8, xp.sqrt(rho / safe), 1.0)
    return r * ratio, xp.where(z > 1e-8, slope / ratio, 1.0)


def robust(lin: Linearisation, loss: Loss) -> Linearisation:
    """A linearisation under a loss; the priors of the windows' states are left as they are."""
    if loss == "linear":
        return lin
    r, factor = robustify(lin.r[:, :-4], loss)
    lin.r[:, :-4] = r
    lin.states_jac[:, :-4] *= factor[:, :, None]
    lin.slots_jac[:, :-4] *= factor[:, :, None]
    return lin
