"""Effects that the rigs of a fleet share, one by one, and those that are some rigs' own.

The effect with the largest reduction over all rigs is named if noise alone seldom gives as much to
any effect of the catalogue. Its amplitudes are then projected out and all is asked again. An effect
is the kind's if the rigs agree on its amplitudes and if it does not rest on one rig; else it is a
rig's own. The null distribution is drawn: scores of noise alone of every rig, pooled as the
observed ones are, so that effects that resemble each other and grids of shapes count once.
"""

import dataclasses
from collections.abc import Sequence

import numpy as np

from tp_jax import _tails as tails
from tp_jax._blas import one_blas_thread
from tp_jax.estimation.normal_equations import efficient_inverse
from tp_jax.gap.detectability import TIED
from tp_jax.gap.policy import POLICY, SharedPolicy
from tp_jax.gap.shared.pooling import Agreement, Pooled, agreement, cosine, pool
from tp_jax.gap.shared.scores import Key, RigScores, of_like_units
from tp_jax.gap.structure import roots

KIND, OWN = "kind", "own"
"""Verdicts: shared by all rigs of the kind; a rig's own."""


@dataclasses.dataclass(frozen=True)
class SharedEffect:
    """An effect that was named.

    Attributes:
        pooled: over all rigs. verdict: KIND or OWN. p: family-wise, of the whole catalogue.
        agreement: of the rigs. differ: whether they do not agree.
        largest: the rig that contributes most. without: the effect over the others; p_without: p
            of that.
        showing: rigs that show it alone, at the family-wise level over the rigs.
        tied: effects that the fleet cannot tell from it.
    """

    pooled: Pooled
    verdict: str
    p: float
    agreement: Agreement
    differ: bool
    largest: int
    without: Pooled
    p_without: float
    showing: tuple[int, ...]
    tied: tuple[str, ...]


@dataclasses.dataclass(frozen=True)
class Candidate:
    """An effect of the catalogue before any is named: at its best shape, over all rigs."""

    pooled: Pooled
    p: float


@dataclasses.dataclass(frozen=True)
class Shared:
    """effects: named, in order. candidates: all that were asked, the most reducing first."""

    effects: tuple[SharedEffect, ...]
    candidates: tuple[Candidate, ...]


@one_blas_thread()
def shared_effects(
    rigs: Sequence[RigScores], seed: int = 0, policy: SharedPolicy = POLICY.shared
) -> Shared:
    """Finds which effects the rigs of a fleet share, and which are some rigs' own.

    Args:
        rigs: their scores; an effect is asked of those that have it in the same units.
        seed: of the draws of noise alone.
        policy: what decides.
    """
    rigs = of_like_units(rigs)
    noise = _noise(rigs, seed, policy.draws)
    named: list[SharedEffect] = []
    first: tuple[Candidate, ...] = ()
    for _ in range(policy.most):
        kinds = [each.pooled.key for each in named if each.verdict == KIND]
        owns = [each.pooled.key for each in named if each.verdict == OWN]
        every = _every(rigs, kinds, owns, policy.rigs)
        largest = _largest_of_noise(every, noise)
        best = _best(every)
        found = [Candidate(pooled, _p(largest, pooled)) for pooled in best]
        first = first or tuple(found)
        passing = [each for each in found if each.p < policy.level]
        floor = policy.least * max((each.pooled.drop for each in named), default=0.0)
        if not passing or passing[0].pooled.drop < floor:
            break
        named.append(_judged(rigs, passing[0], best, kinds, owns, largest, policy))
    return Shared(tuple(named), first)


def _noise(rigs: Sequence[RigScores], seed: int, draws: int) -> list[np.ndarray]:
    """Scores (E, draws) of noise alone, of each rig."""
    rng = np.random.default_rng(seed)
    return [
        roots(rig.noise[None])[0] @ rng.standard_normal((len(rig.score), draws)) for rig in rigs
    ]


def _every(
    rigs: Sequence[RigScores], kinds: Sequence[Key], owns: Sequence[Key], least: int
) -> list[Pooled]:
    """All effects at all shapes that are not named yet and that enough rigs can show."""
    named = {effect for effect, _ in (*kinds, *owns)}
    keys = dict.fromkeys(v.key for rig in rigs for v in rig.variants if v.effect not in named)
    return [
        pool(rigs, key, kinds, owns)
        for key in keys
        if sum(key in rig.by_key for rig in rigs) >= least
    ]


def _best(every: Sequence[Pooled]) -> list[Pooled]:
    """Each effect at its best shape, the one furthest from chance first."""
    found: dict[str, Pooled] = {}
    for pooled in every:
        known = found.get(pooled.key[0])
        if known is None or pooled.drop > known.drop:
            found[pooled.key[0]] = pooled
    return sorted(found.values(), key=lambda each: -each.statistic)


def _largest_of_noise(every: Sequence[Pooled], noise: Sequence[np.ndarray]) -> np.ndarray:
    """(draws,) largest statistic of all effects where there is noise alone."""
    if not every:
        return np.zeros(noise[0].shape[1] if noise else 1)
    ends = np.cumsum([0, *(len(pooled.score) for pooled in every)])
    scores = np.zeros((ends[-1], noise[0].shape[1]))
    for i, drawn in enumerate(noise):
        rows = np.zeros((ends[-1], len(drawn)))
        for at, pooled in zip(ends, every, strict=False):
            for part, follow in zip(pooled.parts, pooled.follow, strict=True):
                if part.rig == i:
                    rows[at : at + len(follow)] = np.sqrt(part.dispersion) * follow
        scores += rows @ drawn
    largest = np.zeros(scores.shape[1])
    for at, pooled in zip(ends, every, strict=False):
        found = _drops(pooled, scores[at : at + len(pooled.score)])
        largest = np.maximum(largest, -tails.log_chi_square(found, len(pooled.score)))
    return largest


def _drops(pooled: Pooled, scores: np.ndarray) -> np.ndarray:
    """(draws,) reductions by scores (q, draws); bounds count for one amplitude alone.

    Without bounds there are larger ones, so the test of several bounded amplitudes errs on the
    safe side.
    """
    inverse = efficient_inverse(pooled.information)
    drop = np.einsum("qd,qd->d", inverse @ scores, scores)
    if len(scores) > 1:
        return drop
    free = -(inverse @ scores)[0]
    beyond = free - np.clip(free, *pooled.limits[0])
    return np.maximum(drop - pooled.information[0, 0] * beyond**2, 0.0)


def _p(largest: np.ndarray, pooled: Pooled) -> float:
    return float((1 + (largest >= pooled.statistic).sum()) / (1 + largest.size))


def _judged(
    rigs: Sequence[RigScores],
    found: Candidate,
    best: Sequence[Pooled],
    kinds: Sequence[Key],
    owns: Sequence[Key],
    largest: np.ndarray,
    policy: SharedPolicy,
) -> SharedEffect:
    """An effect that passes: the kind's, or some rigs' own."""
    pooled = found.pooled
    agreed = agreement(pooled)
    others = {
        part.rig: pool(rigs, pooled.key, kinds, owns, without=part.rig) for part in pooled.parts
    }
    rig, rest = min(others.items(), key=lambda item: item[1].drop)
    p_without = _p(largest, rest)
    same_sign = float(rest.estimate @ rest.information @ pooled.estimate) > 0.0
    holds = same_sign and (p_without < policy.level or rest.drop >= policy.kept * pooled.drop)
    differ = agreed.p < policy.differ and agreed.spread > policy.spread
    showing = tuple(
        part.rig
        for part, p in zip(pooled.parts, agreed.p_by_rig, strict=True)
        if p * len(pooled.parts) < policy.level
    )
    tied = tuple(
        each.key[0]
        for each in best
        if each.key[0] != pooled.key[0]
        and (
            pooled.statistic - each.statistic < policy.near
            or cosine(rigs, pooled.key, each.key, kinds, owns) > TIED
        )
    )
    verdict = KIND if holds and not differ else OWN
    return SharedEffect(
        pooled, verdict, found.p, agreed, differ, rig, rest, p_without, showing, tied
    )
