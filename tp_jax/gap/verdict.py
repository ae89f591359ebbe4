"""The verdict, from what was measured on data that no choice has touched."""

from tp_jax.gap.choice import IN_CATALOGUE, LEVEL
from tp_jax.gap.held_out import Shrink

EXPLAINED = 0.85  # lower end of the interval of shrink
NEGLIGIBLE = 0.999  # lower end from which what stays is too little to ask where it comes from
EXCESS = 3.0  # standard errors of the misfit


def verdict(
    structure_p: float, structure_p_after: float, excess_z: float, causes: int, shrink: Shrink
) -> str:
    """no_gap, explained or unknown.

    Args:
        structure_p: family-wise p of the tests of structure at the baseline (`both`).
        structure_p_after: the same where the causes are added.
        excess_z: standard errors by which the baseline's misfit exceeds the noise.
        causes: number of accepted causes.
        shrink: on held-out data.

    A cause that is not the right one may still take most of a gap: what it leaves then comes again
    where the motion does. So `explained` asks that nothing but noise stays, or next to nothing.
    """
    if structure_p >= LEVEL and excess_z < EXCESS:
        return "no_gap"
    if not causes or shrink.ci95 is None or shrink.ci95[0] < EXPLAINED:
        return "unknown"
    if structure_p_after < LEVEL and shrink.ci95[0] < NEGLIGIBLE:
        return "unknown"
    return "explained"


def both(catalogue_p: float, free_p: float) -> float:
    """Family-wise p of the two tests of structure: in the catalogue's directions, and in any."""
    return min(catalogue_p / IN_CATALOGUE, free_p / (1.0 - IN_CATALOGUE), 1.0)
