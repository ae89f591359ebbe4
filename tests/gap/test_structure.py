"""The test of structure holds its level, with few blocks and many candidates."""

import itertools
import types

import numpy as np

from tp_jax.gap.structure import structure_test

CANDIDATES, COMMON = 12, 3
COLUMN = 6  # of candidate 3


def screen(rng, n_blocks=40, heavy=False, effect=0.0, where=None, noise=1.0):
    """Scores of candidates that share a part, in blocks that tell very differently much.

    effect: of candidate 3, in units of its amplitude, in the blocks `where`.
    """
    sizes = [1 + i % 3 for i in range(CANDIDATES)]
    mix = rng.normal(size=(COMMON, sum(sizes)))
    scale = rng.gamma(1.0, size=(n_blocks, 1)) + 1e-3
    shared = rng.standard_t(4, size=(n_blocks, COMMON)) / np.sqrt(2.0) if heavy else None
    if shared is None:
        shared = rng.normal(size=(n_blocks, COMMON))
    blocks = noise * scale * (shared @ mix + rng.normal(size=(n_blocks, sum(sizes))))
    V = scale[:, :, None] ** 2 * (mix.T @ mix + np.eye(sum(sizes)))
    ends = np.cumsum([0, *sizes])
    rows = [slice(a, b) for a, b in itertools.pairwise(ends)]
    if where is not None:
        # nothing is to be learnt of it elsewhere
        for b in set(range(n_blocks)) - set(where):
            blocks[b, rows[3]] = 0.0
            V[b, rows[3]] = V[b, :, rows[3]] = 0.0
    blocks += effect * V[:, :, COLUMN]
    scored = tuple(types.SimpleNamespace(blocks=blocks[:, r], rows=r) for r in rows)
    return types.SimpleNamespace(scored=scored, information_by_block=V)


def null_p(rng, **how):
    return structure_test(screen(rng, **how), seed=int(rng.integers(1 << 30))).p


def test_false_alarms_stay_near_the_level():
    rng = np.random.default_rng(0)
    p = np.array([null_p(rng) for _ in range(120)])
    # 120 trials at 5 %: 13 or more happen once in a hundred.
    assert (p < 0.05).sum() <= 12
    assert np.median(p) > 0.3


def test_heavy_tails_and_a_wrong_noise_level_are_no_structure():
    rng = np.random.default_rng(5)
    p = np.array([null_p(rng, heavy=True, noise=1.5) for _ in range(120)])
    assert (p < 0.05).sum() <= 12


def test_an_effect_is_found():
    rng = np.random.default_rng(1)
    seen = screen(rng)
    V = seen.information_by_block[:, COLUMN, COLUMN].sum()
    rng = np.random.default_rng(1)
    found = structure_test(screen(rng, effect=6.0 / np.sqrt(V)), seed=0)
    assert found.p < 0.01
    assert found.by_variant[3] == found.p  # others that share its part may do so too


def test_an_effect_that_shows_in_few_blocks_is_found():
    """Where runs begin, say: signs of six blocks could not tell it from chance."""
    where = range(0, 40, 7)
    rng = np.random.default_rng(2)
    V = screen(rng, where=where).information_by_block[:, COLUMN, COLUMN].sum()
    rng = np.random.default_rng(2)
    found = structure_test(screen(rng, where=where, effect=20.0 / np.sqrt(V)), seed=0)
    assert found.p < 0.05
    assert int(np.argmin(found.by_variant)) == 3


def test_same_seed_same_p():
    seen = screen(np.random.default_rng(2))
    assert structure_test(seen, seed=4).p == structure_test(seen, seed=4).p
