"""Information of blocks by slot is that of columns by unknown, which need far more memory."""

import numpy as np
import pytest

from tests.standing_in import standing_in
from tp_jax.estimation.layout import Unknown
from tp_jax.estimation.linearisation import Linearisation, gathered, places, spread
from tp_jax.gap.block_information import BlockInformation
from tp_jax.gap.screen import Scored, Screen
from tp_jax.gap.structure import dispersions, scores_of_noise

BLOCKS, SAMPLES, RECORDINGS = 12, 40, 4
SLOTS = ("drag", "wear", "zero", "J")
UNKNOWNS = (
    Unknown("drag"),
    *(Unknown("wear", i) for i in range(RECORDINGS)),
    *(Unknown("zero", i) for i in range(RECORDINGS) if i != 2),  # that one is at a bound
    Unknown("J"),
)
EFFECTS = 1 + RECORDINGS


@pytest.fixture
def made():
    """Derivatives of blocks by slot; where they stand; by unknown; residuals."""
    rng = np.random.default_rng(0)
    recording = np.repeat(np.arange(RECORDINGS), BLOCKS // RECORDINGS)
    by_slot = rng.standard_normal((BLOCKS, SAMPLES, len(SLOTS)))
    by_slot[..., 0] += by_slot[..., 2]  # what the drag does, the zero takes in part
    lin = standing_in(Linearisation, slots_jac=by_slot, slots=SLOTS, recording=recording)
    return by_slot, places(UNKNOWNS, SLOTS, recording), spread(lin, UNKNOWNS), rng


def test_sums_by_unknown(made):
    by_slot, to, jac, rng = made
    r = rng.standard_normal((BLOCKS, SAMPLES))
    n = len(UNKNOWNS)
    own = by_slot.transpose(0, 2, 1)
    np.testing.assert_allclose(
        gathered(own @ by_slot, to, n), np.einsum("bsu,bsv->uv", jac, jac), atol=1e-12
    )
    np.testing.assert_allclose(
        gathered((own @ r[:, :, None])[..., 0], to, n), np.einsum("bsu,bs->u", jac, r), atol=1e-12
    )


@pytest.fixture
def both(made):
    """The information by slot; efficient derivatives by effect and unknown."""
    by_slot, to, jac, rng = made
    H = np.einsum("bsu,bsv->uv", jac, jac)
    gain = np.linalg.solve(H[EFFECTS:, EFFECTS:], H[EFFECTS:, :EFFECTS])
    known = BlockInformation.of_gradients(by_slot.transpose(0, 2, 1) @ by_slot, to, gain)
    efficient = jac.copy()
    efficient[..., :EFFECTS] -= jac[..., EFFECTS:] @ gain
    return known, efficient, by_slot, rng


def test_scores(both):
    known, efficient, by_slot, rng = both
    r = rng.standard_normal((BLOCKS, SAMPLES, 3))
    own = known.own_scores(by_slot.transpose(0, 2, 1) @ r)
    expected = efficient.transpose(0, 2, 1) @ r
    np.testing.assert_allclose(known.scores(own), expected[:, :EFFECTS], atol=1e-12)
    # once the unknowns are fitted to all of them
    H = efficient.transpose(0, 2, 1) @ efficient
    covariance = np.linalg.inv(H[:, EFFECTS:, EFFECTS:].sum(axis=0))
    step = covariance @ expected[:, EFFECTS:].sum(axis=0)
    np.testing.assert_allclose(
        known.scores(known.after_the_fit(own, covariance)),
        expected[:, :EFFECTS] - H[:, :EFFECTS, EFFECTS:] @ step,
        atol=1e-12,
    )


@pytest.mark.parametrize("rows", [slice(0, 1), slice(1, 5), slice(0, 5)])
def test_information(both, rows):
    known, efficient, _, _ = both
    H, follow = known.of(rows)
    V = efficient.transpose(0, 2, 1) @ efficient
    np.testing.assert_allclose(follow.transpose(0, 2, 1) @ H @ follow, V[:, rows, rows], atol=1e-12)
    np.testing.assert_allclose(known.dense(), V[:, :EFFECTS, :EFFECTS], atol=1e-12)
    assert len(H[0]) <= len(SLOTS)


def test_drawn_scores_scatter_as_they_should(both):
    known, efficient, _, _ = both
    H = efficient.transpose(0, 2, 1) @ efficient
    covariance = np.linalg.inv(H[:, EFFECTS:, EFFECTS:].sum(axis=0))
    V = H[:, :EFFECTS, :EFFECTS].sum(axis=0)
    seen = standing_in(
        Screen, by_block=known, information=V, covariance=covariance, rounding=None, scored=()
    )
    drawn = np.concatenate([x.sum(axis=0) for x in scores_of_noise(seen, 0)], axis=1)
    sd = np.sqrt(np.diag(V))
    np.testing.assert_allclose(np.cov(drawn) / np.outer(sd, sd), V / np.outer(sd, sd), atol=0.1)


def test_an_effect_with_more_amplitudes_than_a_block_has_columns(both):
    """The same dispersion, whichever way its information is taken apart."""
    known, efficient, _, rng = both
    noise = 1.5 * rng.standard_normal((BLOCKS, SAMPLES))
    blocks = np.einsum("bsx,bs->bx", efficient, noise)[:, :EFFECTS]
    every = slice(0, EFFECTS)
    assert known.of(every)[0].shape[1] < EFFECTS
    scored = (standing_in(Scored, rows=every, blocks=blocks),)
    few = standing_in(Screen, by_block=known, scored=scored)
    H = efficient.transpose(0, 2, 1) @ efficient
    to = np.tile(np.arange(EFFECTS), (BLOCKS, 1))
    whole = BlockInformation(H[:, :EFFECTS, :EFFECTS], to, np.zeros((0, EFFECTS)))
    np.testing.assert_allclose(
        dispersions(few), dispersions(standing_in(Screen, by_block=whole, scored=scored))
    )
