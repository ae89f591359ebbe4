"""Tests if an effect earns its place among the causes, and which of several does so best."""

import numpy as np

from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.gap.crossvalidation import gain, left_out_cost
from tp_jax.gap.free_structure import free_structure
from tp_jax.gap.policy import POLICY
from tp_jax.gap.refit import Refit, removable
from tp_jax.gap.screen import screen
from tp_jax.gap.structure import structure_test

EARNS = 2.5  # standard errors by which a cause must lower the left-out cost
TIE, TIE_PART = 2.0, 0.1  # tied: within two standard errors, and within a tenth of the gain
MOST_PART = 0.5  # of the removable gap: a cause that takes so much is not asked for its scatter
SURELY = 5.0  # standard deviations of chance, for a gap to be one
LIKELIER, PER_AMPLITUDE = 16.0, 4.0  # twice a logarithm of likelihoods, of many candidates
NOISE_ALONE = 0.1  # of the noise's variance: three standard errors of that and more
LEAST_PART = 0.01  # of the removable gap that a cause must take with it, or be the last of it
CLEARLY = 64.0  # twice a logarithm of likelihoods, of a cause that takes less
BESIDE = 0.25  # of what it takes: what others may still promise


def earned(drop: float, error: float, gap: float, result: Refit) -> bool:
    """True where a fall of the left-out sum of squares makes a cause of an effect.

    A cause that shows in a few blocks only has a large scatter and is no less real: half of a gap
    that is there beyond chance, gone from data left out, is enough; and so is a likelihood ratio
    where the effect leaves noise alone, since then it is one.

    Args:
        drop, error: fall and its standard error. gap: of the baseline, in the same unit.
        result: the fit with it.
    """
    if drop <= LEAST_PART * gap:
        return False
    chance = np.sqrt(2.0 * result.fit.dof)
    ratio = LIKELIER + PER_AMPLITUDE * amplitudes(result)
    return bool(
        drop > EARNS * error
        or (gap > SURELY * chance and drop > MOST_PART * gap)
        or (removable(result.fit) < NOISE_ALONE * result.fit.dof and drop > ratio)
    )


def likeliest(refits: dict[str, Refit]) -> str:
    """The refit with the smallest sum of squares, amplitudes counted.

    What is left out says less than the fit itself where an effect takes next to nothing.
    """
    return min(refits, key=lambda id: refits[id].cost + PER_AMPLITUDE * amplitudes(refits[id]))


def clearly(setting: PreparedCampaign, before: Refit, after: Refit, seed: int) -> bool:
    """True where an effect that takes next to nothing of a large gap is there beyond doubt.

    A law of friction that is not quite the rig's leaves something too, which other effects take in
    part. So such an effect is a cause only if it takes more than the best of many would, and what
    it leaves is noise: of its size, with no readings off, and nothing else promises much.

    Args:
        before, after: with sharp friction.
    """
    took = before.cost - after.cost
    if took <= CLEARLY + PER_AMPLITUDE * amplitudes(after):
        return False
    if removable(after.fit) > NOISE_ALONE * after.fit.dof:
        return False
    if free_structure(setting, after.fit).p < POLICY.structure.left:
        return False
    seen = screen(after.fit, setting, skip=after.ids, states=False)
    promised = max((s.drop for s in seen.scored), default=0.0)
    return promised <= BESIDE * took or structure_test(seen, seed).p >= POLICY.structure.seen


def amplitudes(result: Refit) -> int:
    """Returns the number of amplitudes of the effect that came last."""
    return len(result.variants[-1].unknowns)


def most_promising(
    refits: dict[str, Refit], gains: dict[str, tuple[float, float]], block: np.ndarray
) -> str:
    """The refit with the largest left-out gain; among those tied with it, the simplest."""
    top = max(gains, key=lambda id: gains[id][0])
    costs = {id: left_out_cost(r.fit) for id, r in refits.items()}
    tied = []
    for id in refits:
        behind, error = gain(costs[id], costs[top], block)
        if id == top or (behind < TIE * error and behind < TIE_PART * gains[top][0]):
            tied.append(id)
    return min(tied, key=lambda id: (amplitudes(refits[id]), -gains[id][0]))
