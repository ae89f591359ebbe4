"""Residuals as they would be if the model were right: white noise after the same fit.

Each window's state is estimated from the window, which takes four directions out of its noise and
leaves what remains a little correlated. Tests that assume white residuals would see that; so their
statistics are compared with those of noise that went through the same projection.
"""

import numpy as np
from jaxtyping import Float

from tp_jax.estimation.least_squares import Fit

DRAWS = 60
PRIOR = 1.0 / 3.0
"""Standard deviation of the priors' own residuals: they are weighted for three times the error that
smoothed readings have (`tp_jax.estimation.windows.PRIOR_INFLATION`)."""


def null_residuals(fit: Fit, draws: int = DRAWS, seed: int = 0) -> Float[np.ndarray, "b w m"]:
    """Residuals of pure noise in the layout of the fit's own linearisation.

    Args:
        fit: a windowed fit.
        draws: b, how many.
        seed: of the noise.
    """
    lin = fit.linearisation
    rng = np.random.default_rng(seed)
    noise = rng.standard_normal((draws, *lin.r.shape))
    noise[:, :, :-4] *= lin.valid[:, :-4]
    noise[:, :, -4:] *= PRIOR
    # columns of very different size: scaled first, or a stuck rider's velocity is lost
    size = np.linalg.norm(lin.states_jac, axis=1, keepdims=True)
    basis, _ = np.linalg.qr(lin.states_jac / np.where(size > 0.0, size, 1.0))
    along = np.einsum("wmx,bwm->bwx", basis, noise)
    return noise - np.einsum("wmx,bwx->bwm", basis, along)
