"""Fleets by chance: scores as noise and an effect would give them to the rigs that were seen.

The scores of a rig are normal about -V a, of covariance V: V the information of its screen, a the
amplitudes of the effect that all rigs of the fleet share.
"""

import dataclasses
from collections.abc import Sequence

import numpy as np

from tp_jax.gap.detectability import FAMILY_WISE, TIED, needed_noncentrality
from tp_jax.gap.shared.pooling import cosine, pool
from tp_jax.gap.shared.scores import Key, RigScores, ScoredVariant
from tp_jax.gap.shared.selection import KIND, shared_effects
from tp_jax.gap.structure import roots

SEED = 48
"""Seed of the draws; no number that decides was chosen on them."""

DRAWS = 10
"""Fleets with each effect, and fleets with nothing."""

PART = 0.5
"""Part of the size that half of the rigs would detect alone."""

MOST_TIED = 3
"""Members of a group of effects that cannot be told apart, up to which naming one is right."""

EFFECTS = (
    "bearing_drag",
    "bearing_stribeck",
    "column_tilt",
    "contact_asymmetry",
    "contact_stribeck",
    "drive_harmonics",
    "sensor1_eccentricity",
    "spring_asymmetry",
    "spring_hardening",
)
"""Effects that are drawn: of all places, each with amplitudes for the whole rig."""

NOTHING, OWN = "nothing", "each rig an effect of its own"
"""Alternatives to an effect that a fleet shares."""

MULTIPLES = (1.0, 5.0)
"""Times the detectable size that a rig's own effect has, uniform in the logarithm."""


@dataclasses.dataclass(frozen=True)
class Drawn:
    """A fleet.

    Attributes:
        effect: that its rigs share, NOTHING or OWN.
        first: the effect that is named first as the kind's; "" for none. right: whether that is
            the shared one or one of a small group that cannot be told from it.
        more: others that are named as the kind's after it.
        named: all effects that are named, as the kind's or as a rig's own.
        alone: how many of the rigs show the shared effect alone, as the most likely of all and
            beyond chance; rigs: of how many. Of a fleet without one: any effect.
    """

    effect: str
    first: str
    right: bool
    more: tuple[str, ...]
    named: tuple[str, ...]
    alone: int
    rigs: int


def drawn_fleets(rigs: Sequence[RigScores]) -> list[Drawn]:
    """Fleets with each of the effects that the rigs can show, and as many without a shared one."""
    found = []
    for effect in (NOTHING, OWN, *EFFECTS):
        for number in range(DRAWS):
            fleet = drawn_fleet(rigs, effect, number)
            if fleet is not None:
                found.append(judged(fleet, effect, number))
    return found


def drawn_fleet(rigs: Sequence[RigScores], effect: str, number: int) -> list[RigScores] | None:
    """The rigs with other chance; None where no rig can show the effect.

    Args:
        rigs: whose information is taken. effect: that they share, NOTHING or OWN. number: of the
            draw.
    """
    rng = np.random.default_rng([SEED, number, *effect.encode()])
    hidden: list[tuple[Key, np.ndarray] | None] = [None] * len(rigs)
    if effect == OWN:
        hidden = [_own(rig, rng) for rig in rigs]
    elif effect != NOTHING:
        keys = sorted({v.key for rig in rigs for v in rig.variants if v.effect == effect})
        if not keys:
            return None
        key = keys[int(rng.integers(len(keys)))]
        amplitudes = half_detectable(rigs, key, rng)
        hidden = [(key, amplitudes) if key in rig.by_key else None for rig in rigs]
    return [_with_scores(rig, each, rng) for rig, each in zip(rigs, hidden, strict=True)]


def _own(rig: RigScores, rng: np.random.Generator) -> tuple[Key, np.ndarray]:
    """Any effect that a rig can show, well beyond the detectable size."""
    ids = sorted({v.effect for v in rig.variants if _shown(rig, v)})
    id = ids[int(rng.integers(len(ids)))]
    keys = [v.key for v in rig.variants if v.effect == id and _shown(rig, v)]
    key = keys[int(rng.integers(len(keys)))]
    multiple = MULTIPLES[0] * (MULTIPLES[1] / MULTIPLES[0]) ** rng.random()
    return key, multiple / PART * half_detectable([rig], key, rng)


def _shown(rig: RigScores, variant: ScoredVariant) -> bool:
    """True if the rig can tell anything of all of an effect's amplitudes."""
    return bool(np.all(np.diag(rig.information)[variant.columns] > 0.0))


def _with_scores(
    rig: RigScores, hidden: tuple[Key, np.ndarray] | None, rng: np.random.Generator
) -> RigScores:
    """The rig with scores of noise and of what is hidden."""
    score = roots(rig.information[None])[0] @ rng.standard_normal(len(rig.score))
    if hidden is not None:
        key, amplitudes = hidden
        score = score - rig.information[:, rig.by_key[key].columns] @ amplitudes
    variants = tuple(dataclasses.replace(v, dispersion=1.0) for v in rig.variants)
    return dataclasses.replace(rig, variants=variants, score=score, noise=rig.information, own=())


def half_detectable(rigs: Sequence[RigScores], key: Key, rng: np.random.Generator) -> np.ndarray:
    """Amplitudes (q,) in a direction by chance, half as large as half of the rigs detect alone."""
    mine = [rig for rig in rigs if key in rig.by_key]
    tests = len({v.effect for v in mine[0].variants})
    every = [rig.information[(c := rig.by_key[key].columns), c] for rig in mine]
    size = np.sqrt(np.mean([np.diag(V) for V in every], axis=0))
    direction = rng.standard_normal(len(size)) / size
    limits = np.stack([rig.limits[rig.by_key[key].columns] for rig in mine])
    low, high = limits[:, :, 0].max(axis=0), limits[:, :, 1].min(axis=0)
    direction = np.where(
        low == 0.0, abs(direction), np.where(high == 0.0, -abs(direction), direction)
    )
    known = np.median([direction @ V @ direction for V in every])
    return PART * np.sqrt(needed_noncentrality(len(size), tests) / known) * direction


def judged(fleet: Sequence[RigScores], effect: str, number: int) -> Drawn:
    """Judges what the fleet names, and its rigs alone, whose own diagnoses name what they show."""
    firsts = [first_alone(rig) for rig in fleet]
    fleet = [
        dataclasses.replace(rig, own=() if key is None else (key,))
        for rig, key in zip(fleet, firsts, strict=True)
    ]
    found = shared_effects(fleet, seed=number)
    kinds = [each for each in found.effects if each.verdict == KIND]
    first = kinds[0].pooled.key[0] if kinds else ""
    tied = set(kinds[0].tied) if kinds else set()
    right = first == effect or (effect in tied and len(tied) < MOST_TIED)
    named = tuple(each.pooled.key[0] for each in found.effects)
    if effect in (NOTHING, OWN):
        right = not kinds if effect == OWN else not named
    alone = sum(
        key is not None and _is(rig, key, effect) for rig, key in zip(fleet, firsts, strict=True)
    )
    more = tuple(each.pooled.key[0] for each in kinds[1:])
    return Drawn(effect, first, right, more, named, alone, len(fleet))


def first_alone(rig: RigScores) -> Key | None:
    """The most likely effect on a rig alone, at its best shape; None if it is not beyond chance."""
    best: dict[str, tuple[float, Key]] = {}
    for v in rig.variants:
        pooled = pool([rig], v.key)
        best[v.effect] = max(best.get(v.effect, (-np.inf, v.key)), (pooled.statistic, v.key))
    statistic, key = max(best.values())
    return None if statistic < -np.log(FAMILY_WISE / len(best)) else key


def _is(rig: RigScores, key: Key, effect: str) -> bool:
    """True if what a rig shows is the effect (any, where none is shared), or like it."""
    if effect in (NOTHING, OWN, key[0]):
        return True
    every = [v.key for v in rig.variants if v.effect == effect]
    return any(cosine([rig], key, each) > TIED for each in every)
