"""The verdict, from what was measured on data that no choice has touched."""

import dataclasses

from tp_jax import _tails as tails
from tp_jax.gap.held_out import Shrink
from tp_jax.gap.policy import POLICY, Policy, StructurePolicy
from tp_jax.results.diagnosis import Verdict


@dataclasses.dataclass(frozen=True)
class Evidence:
    """Evidence that a verdict rests on.

    Attributes:
        structure_p: family-wise p of the tests of structure at the baseline (`combined`).
        structure_p_after: the same with the causes.
        causes: number of accepted causes.
        probability: of the least probable of them, each with those it is tied with.
        shrink: on held-out data.
        rest: mean square that is left on held-out data beyond the noise, over the noise's variance.
        rest_error: its standard error.
        gap_rms, rest_rms: what exceeds the noise there before and after, root mean squares [rad],
            in windows or in a free run, whichever is more.
        worse: whether the model with the causes predicts held-out data worse than that without.
    """

    structure_p: float
    structure_p_after: float
    causes: int
    probability: float
    shrink: Shrink
    rest: float
    rest_error: float
    gap_rms: float = float("inf")
    rest_rms: float = float("inf")
    worse: bool = False


def verdict(e: Evidence, tolerance: float = 0.0, policy: Policy = POLICY) -> Verdict:
    """no_gap, explained or unknown.

    Args:
        e: what was measured.
        tolerance: root mean square [rad] below which a gap matters to nobody; with 0 every gap
            matters that the tests see.
        policy: thresholds.

    `explained` asks that the causes are probable and that on data not used for the choice nothing
    is left beyond the noise, or next to nothing of a large gap, or less than the tolerance. A cause
    that is not the right one may take most of a gap: what it leaves then comes again where the
    motion does. A gap that is as large as before on such data is not explained at all, however
    small it is.
    """
    limits = policy.verdict
    if e.structure_p >= policy.structure.alarm:
        return "no_gap"
    if 0.0 < tolerance and e.gap_rms <= tolerance:
        return "no_gap"
    if not e.causes or e.worse or e.probability < limits.probability:
        return "unknown"
    if 0.0 < tolerance and e.rest_rms <= tolerance:
        return "explained"
    if e.shrink.value is not None and e.shrink.value <= 0.0:
        return "unknown"
    noise = e.rest <= limits.excess * e.rest_error
    if noise and e.structure_p_after >= policy.structure.level:
        return "explained"
    low = e.shrink.ci95[0] if e.shrink.ci95 else 0.0
    little = e.rest <= limits.left + limits.excess * e.rest_error
    return "explained" if little and low >= limits.gone else "unknown"


def combined(
    catalogue_p: float, free_p: float, excess_z: float, policy: StructurePolicy = POLICY.structure
) -> float:
    """Family-wise p that a fit leaves nothing but noise.

    The tests in the catalogue's directions, in any, and of the misfit's size share the level
    (Bonferroni, in unequal parts), so that whatever rejects shows in this one number.

    Args:
        catalogue_p, free_p: of the first two.
        excess_z: standard errors by which the misfit exceeds the noise.
        policy: their parts of the level.
    """
    misfit_p = float(tails.normal(excess_z))
    parts = catalogue_p / policy.catalogue, free_p / policy.free, misfit_p / policy.misfit
    return min(*parts, 1.0)
