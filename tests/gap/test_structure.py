"""The test of structure holds its level, with few blocks and many candidates."""

import types

import numpy as np

from tp_jax.gap.structure import structure_test


def scored(blocks):
    return types.SimpleNamespace(blocks=blocks)


def null_p(rng, n_blocks=40, candidates=12):
    out = []
    common = rng.standard_t(4, size=(n_blocks, 3))  # heavy tails, shared between candidates
    for i in range(candidates):
        q = 1 + i % 3
        mix = rng.normal(size=(3, q))
        scale = rng.gamma(1.0, size=(n_blocks, 1))  # blocks of very different weight
        out.append(scored(scale * (common @ mix + rng.normal(size=(n_blocks, q)))))
    return structure_test(out, seed=int(rng.integers(1 << 30))).p


def test_false_alarms_stay_near_the_level():
    rng = np.random.default_rng(0)
    p = np.array([null_p(rng) for _ in range(120)])
    # 120 trials at 5 %: 13 or more happen once in a hundred.
    assert (p < 0.05).sum() <= 12


def test_an_effect_is_found():
    rng = np.random.default_rng(1)
    many = [scored(rng.normal(size=(40, 1))) for _ in range(10)]
    many[3] = scored(rng.normal(size=(40, 1)) + 1.2)
    found = structure_test(many, seed=0)
    assert found.p < 0.01
    assert int(np.argmin(found.by_variant)) == 3


def test_same_seed_same_p():
    rng = np.random.default_rng(2)
    many = [scored(rng.normal(size=(30, 2))) for _ in range(5)]
    assert structure_test(many, seed=4).p == structure_test(many, seed=4).p
