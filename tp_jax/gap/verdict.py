"""The verdict, from what was measured on data that no choice has touched."""

import dataclasses

from tp_jax.gap.choice import IN_CATALOGUE
from tp_jax.gap.held_out import Shrink
from tp_jax.gap.policy import POLICY, VerdictPolicy


@dataclasses.dataclass(frozen=True)
class Evidence:
    """What a verdict rests on.

    Attributes:
        structure_p: family-wise p of the tests of structure at the baseline (`both`).
        structure_p_after: the same with the causes.
        excess_z: standard errors by which the baseline's misfit exceeds the noise.
        causes: number of accepted causes.
        probability: of the least probable of them, each with those it is tied with.
        shrink: on held-out data.
        rest: mean square that is left on held-out data beyond the noise, over the noise's variance.
        rest_error: its standard error.
        gap_rms, rest_rms: what exceeds the noise there before and after, root mean squares [rad].
        worse: whether the model with the causes predicts held-out data worse than that without.
    """

    structure_p: float
    structure_p_after: float
    excess_z: float
    causes: int
    probability: float
    shrink: Shrink
    rest: float
    rest_error: float
    gap_rms: float = float("inf")
    rest_rms: float = float("inf")
    worse: bool = False


def verdict(e: Evidence, tolerance: float = 0.0, policy: VerdictPolicy = POLICY.verdict) -> str:
    """no_gap, explained or unknown.

    Args:
        e: what was measured.
        tolerance: root mean square [rad] below which a gap matters to nobody.
        policy: thresholds.

    `explained` asks that the causes are probable and that on data not used for the choice nothing
    is left beyond the noise, or next to nothing of a large gap, or less than the tolerance. A cause
    that is not the right one may take most of a gap: what it leaves then comes again where the
    motion does.
    """
    if e.structure_p >= policy.level and e.excess_z < policy.excess:
        return "no_gap"
    if e.gap_rms <= tolerance:
        return "no_gap"
    if not e.causes or e.worse or e.probability < policy.probability:
        return "unknown"
    if e.rest_rms <= tolerance:
        return "explained"
    noise = e.rest <= policy.excess * e.rest_error
    if noise and e.structure_p_after >= policy.level:
        return "explained"
    low = e.shrink.ci95[0] if e.shrink.ci95 else 0.0
    little = e.rest <= policy.left + policy.excess * e.rest_error
    return "explained" if little and low >= policy.gone else "unknown"


def both(catalogue_p: float, free_p: float) -> float:
    """Family-wise p of the two tests of structure: in the catalogue's directions, and in any."""
    return min(catalogue_p / IN_CATALOGUE, free_p / (1.0 - IN_CATALOGUE), 1.0)
