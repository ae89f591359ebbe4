"""Noise is whitened in the traced residuals as it is in a problem's linearisation."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np

from tests.rigs import bench_problem
from tp_jax.estimation.window_residuals import _unfolded, _whitened
from tp_jax.recordings.colour import Colour


def test_whitening_lane_by_lane():
    problem = bench_problem(0.4)
    colours = (Colour(0.5, 0.8), Colour(-0.2, 0.0))
    prepared = tuple(dataclasses.replace(p, colour=colours) for p in problem.prepared)
    problem = dataclasses.replace(problem, prepared=prepared)
    states, gain = np.zeros((problem.windows.n, 4)), np.zeros((problem.windows.n, 4, 2))
    rng = np.random.default_rng(0)
    for packed in problem.blocks():
        which, places, block = packed
        lanes = jax.tree.map(jnp.asarray, _unfolded(problem, states, gain, *packed))
        x = rng.normal(size=(*block.ts.T.shape, 2, 3))
        white = np.asarray(_whitened(jnp.asarray(x), lanes))
        for i, (_, lane, at, _) in zip(which, places, strict=True):
            span = slice(at, at + problem.windows.count[i])
            for c, colour in enumerate(colours):
                wanted = colour.whiten(x[lane, span, c])
                np.testing.assert_allclose(white[lane, span, c], wanted, atol=1e-6)
