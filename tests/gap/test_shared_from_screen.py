"""A rig's scores, of a screen that is made up: what is kept of it, and what is projected out."""

import types

import numpy as np
import pytest

from tests.blocks import whole
from tests.standing_in import standing_in
from tp_jax.effects.base import Amplitude
from tp_jax.estimation.layout import Unknown
from tp_jax.gap.directions import Variant
from tp_jax.gap.screen import Scored, Screen
from tp_jax.gap.shared.from_screen import rig_scores
from tp_jax.gap.structure import dispersions

BLOCKS, SAMPLES = 30, 20


def scored(id, at, q, *, by_recording=False, drop=1.0, shapes=(), blocks=None, V=None):
    amplitudes = tuple(Amplitude(f"a{i}", "N m") for i in range(1 if by_recording else q))
    effect = types.SimpleNamespace(id=id, location="spring", amplitudes=amplitudes)
    unknowns = tuple(Unknown(f"{id}.a{i}", i if by_recording else None) for i in range(q))
    variant = standing_in(Variant, effect=effect, shapes=shapes, unknowns=unknowns)
    rows = slice(at, at + q)
    limits = np.tile((-np.inf, np.inf), (q, 1))
    return Scored(
        variant, drop, drop, np.zeros(q), V[rows, rows], blocks[:, rows], np.zeros(0), rows, limits
    )


@pytest.fixture
def seen():
    """Two amplitudes; one for each of three recordings; one, at two shapes."""
    rng = np.random.default_rng(0)
    jac = rng.standard_normal((BLOCKS, SAMPLES, 7))
    noise = 1.5 * rng.standard_normal((BLOCKS, SAMPLES))
    by_block = jac.transpose(0, 2, 1) @ jac
    blocks = np.einsum("bsx,bs->bx", jac, noise)
    V = by_block.sum(axis=0)
    more = {"blocks": blocks, "V": V}
    every = (
        scored("tilt", 0, 2, drop=5.0, **more),
        scored("wear", 2, 3, by_recording=True, drop=9.0, **more),
        scored("drag", 5, 1, shapes=(("n", 1.0),), drop=2.0, **more),
        scored("drag", 6, 1, shapes=(("n", 2.0),), drop=3.0, **more),
    )
    return Screen(every, V, whole(by_block), {}, blocks.sum(axis=0), np.zeros((0, 0)))


def test_effects_of_the_whole_rig_are_kept(seen):
    kept = rig_scores("a", seen, (), 0)
    assert [(v.effect, v.shapes, v.columns) for v in kept.variants] == [
        ("tilt", (), slice(0, 2)),
        ("drag", (("n", 1.0),), slice(2, 3)),
        ("drag", (("n", 2.0),), slice(3, 4)),
    ]
    assert kept.variants[0].amplitudes == (("a0", "N m"), ("a1", "N m"))
    without = rig_scores("a", seen, (), 0, B1_given=False)
    assert without.variants[0].amplitudes == (("a0", "N m/B1"), ("a1", "N m/B1"))
    columns = [0, 1, 5, 6]
    np.testing.assert_allclose(kept.score, seen.total[columns])
    np.testing.assert_allclose(kept.information, seen.information[np.ix_(columns, columns)])
    assert kept.own == ()


def test_own_causes_are_kept_or_projected_out(seen):
    kept = rig_scores("a", seen, ("drag", "wear", "learned"), 0)
    assert kept.own == (("drag", (("n", 2.0),)),), "at its best shape"
    columns, apart = [0, 1, 5, 6], [2, 3, 4]
    V, s = seen.information, seen.total
    # the score of what is left once each recording has its amplitude
    step = np.linalg.solve(V[np.ix_(apart, apart)], s[apart])
    np.testing.assert_allclose(kept.score, s[columns] - V[np.ix_(columns, apart)] @ step)
    # a block of the inverse is the covariance of the rest
    rest = np.linalg.inv(np.linalg.inv(V)[np.ix_(columns, columns)])
    np.testing.assert_allclose(kept.information, rest, rtol=1e-8)


def test_dispersions_are_those_of_the_blocks(seen):
    found = dispersions(seen)
    assert found.shape == (4,)
    np.testing.assert_allclose(found, 1.5**2, rtol=0.35)
    assert [v.dispersion for v in rig_scores("a", seen, (), 0).variants] == [
        found[0],
        found[2],
        found[3],
    ]


def test_a_screen_without_effects_has_none():
    empty = Screen(
        (), np.zeros((0, 0)), whole(np.zeros((3, 0, 0))), {}, np.zeros(0), np.zeros((0, 0))
    )
    assert rig_scores("a", empty, (), 0).variants == ()
