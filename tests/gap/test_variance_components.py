"""Sources of random coefficients are told apart, and the likelihood has the slope it claims."""

import numpy as np
import pytest

from tp_jax.estimation.elimination import eliminate
from tp_jax.gap.variance_components import VarianceComponents, _Solved, attribute

W, M = 30, 60
SOURCE = np.array(["one"] * 5 + ["two"] * 5 + ["three"] * 2)


def windows(rng, one=0.0, two=0.0):
    """Residuals of windows with coefficients of two of three sources, and what is shared."""
    t = np.linspace(0.0, 1.0, M)
    smooth = np.stack([np.cos(np.pi * j * t) for j in range(5)], axis=1)
    rough = np.stack([np.sign(np.sin(2.0 * np.pi * (j + 3) * t + 0.3)) for j in range(5)], axis=1)
    third = rng.normal(size=(M, 2))
    C = np.broadcast_to(np.concatenate([smooth, rough, third], axis=1), (W, M, 12))
    B = rng.normal(size=(W, M, 3))
    X = rng.normal(size=(W, M, 4))
    sizes = np.repeat([one, two, 0.0], [5, 5, 2])
    r = rng.normal(size=(W, M)) + B @ [3.0, -2.0, 1.0]
    r = r + np.einsum("wmq,wq->wm", C, sizes * rng.normal(size=(W, 12)))
    r = r + np.einsum("wmx,wx->wm", X, 10.0 * rng.normal(size=(W, 4)))
    return eliminate(r, X, np.concatenate([C, B], axis=2))


def shares(left, seed=0):
    found = attribute(VarianceComponents(left, SOURCE), np.arange(W) // 2, seed)
    assert found.shares.sum() == pytest.approx(1.0)
    return dict(zip(found.channels, found.shares, strict=True)), found


def test_the_source_is_found():
    rng = np.random.default_rng(0)
    by_name, found = shares(windows(rng, one=1.0))
    assert found.channels[0] == "one"
    assert by_name["one"] > 0.97
    assert found.low[0] > 0.9
    by_name, found = shares(windows(rng, two=0.5))
    assert found.channels[0] == "two"


def test_two_sources_share():
    by_name, _ = shares(windows(np.random.default_rng(1), one=1.0, two=1.0))
    assert min(by_name["one"], by_name["two"]) > 0.3
    assert by_name["three"] < 0.02


def test_noise_gains_next_to_nothing():
    parts = VarianceComponents(windows(np.random.default_rng(2)), SOURCE)
    assert all(parts.fit([n]).gain < 4.0 for n in parts.names)


def test_coefficients_are_those_that_made_the_residuals():
    rng = np.random.default_rng(3)
    left = windows(rng, one=2.0)
    parts = VarianceComponents(left, SOURCE).fit(["one"])
    # what is shared comes out with its sign turned: it is the move that removes it
    np.testing.assert_allclose(parts.shared, [-3.0, 2.0, -1.0], atol=0.1)
    assert not parts.coefficients[:, 5:].any()
    assert parts.coefficients[:, :5].std() == pytest.approx(2.0, rel=0.2)


def test_slope():
    left = windows(np.random.default_rng(4), one=0.5, two=0.2)
    member = np.array([SOURCE == n for n in ("one", "two", "three")])
    size = np.sqrt(np.einsum("wii->i", left.H) / W)
    H, g = left.H / np.outer(size, size), left.g / size

    def at(logs):
        return _Solved(np.asarray(logs), member, H, g, left.cost, 12)

    where, h = np.array([1.0, 3.0, 0.5]), 1e-4
    slope = [(at(where + h * e).value - at(where - h * e).value) / (2 * h) for e in np.eye(3)]
    np.testing.assert_allclose(at(where).slope, slope, rtol=1e-5, atol=1e-5)
