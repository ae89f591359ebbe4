"""The verdict, from what was measured on data that no choice has touched."""

from tp_jax.gap.choice import LEVEL
from tp_jax.gap.held_out import Shrink

EXPLAINED = 0.85  # lower end of the interval of shrink


def verdict(structure_p: float, excess_z: float, causes: int, shrink: Shrink) -> str:
    """no_gap, explained or unknown.

    Args:
        structure_p: family-wise p of the test of structure at the baseline.
        excess_z: standard errors by which the baseline's misfit exceeds the noise.
        causes: number of accepted causes.
        shrink: on held-out data.
    """
    if structure_p >= LEVEL and excess_z < 4.0:
        return "no_gap"
    if causes and shrink.ci95 is not None and shrink.ci95[0] >= EXPLAINED:
        return "explained"
    return "unknown"
