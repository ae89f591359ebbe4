"""Whitening sample by sample is whitening at once."""

import numpy as np
import pytest

from tp_jax.recordings.colour import Colour

KINDS = [Colour(), Colour(0.5, 0.8), Colour(0.3, 0.3), Colour(-0.2, 0.0), Colour(0.05, 0.95)]


@pytest.mark.parametrize("colour", KINDS, ids=str)
def test_the_recursion_of_the_innovations(colour):
    x = np.random.default_rng(0).normal(size=400)
    a, b, s = colour.innovations(x.size)
    e = np.zeros(x.size)
    for t in range(x.size):
        e[t] = x[t] - (a[t] * x[t - 1] + b[t] * e[t - 1] if t else 0.0)
    np.testing.assert_allclose(e * s, colour.whiten(x), atol=1e-6)
