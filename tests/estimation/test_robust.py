"""Losses, as squares of other residuals."""

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.optimize import least_squares

from tp_jax.estimation.robust import LOSSES, TUNING, robustify

R = np.array([-30.0, -1.0, -1e-7, 0.0, 1e-3, 0.5, 1.3, 1.4, 8.0])


@pytest.mark.parametrize("loss", LOSSES)
def test_squares_sum_to_scipys_loss(loss):
    changed, _ = robustify(R, loss)
    scale = TUNING.get(loss, 1.0)
    for r, c in zip(R, changed, strict=True):
        # a fit with nothing to fit: twice its cost is the loss
        found = least_squares(
            lambda x, r=r: np.array([r + 0.0 * x[0]]),
            [0.0],
            loss=loss.replace("-", "_"),
            f_scale=scale,
            max_nfev=1,
        )
        assert c**2 == pytest.approx(2.0 * found.cost, rel=1e-6, abs=1e-15)
        assert np.sign(c) == np.sign(r)


@pytest.mark.parametrize("loss", LOSSES)
def test_factors_are_derivatives(loss):
    h = 1e-6
    _, factor = robustify(R, loss)
    up, down = robustify(R + h, loss)[0], robustify(R - h, loss)[0]
    smooth = np.abs(np.abs(R) - TUNING.get(loss, 1.0)) > 1e-3
    np.testing.assert_allclose(((up - down) / (2 * h))[smooth], factor[smooth], rtol=1e-5)


@pytest.mark.parametrize("loss", LOSSES)
def test_the_same_under_jax(loss):
    for mine, theirs in zip(robustify(R, loss), robustify(jnp.asarray(R), loss, jnp), strict=True):
        np.testing.assert_allclose(mine, theirs, rtol=1e-12)
