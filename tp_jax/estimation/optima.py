"""Groups of starts that have found the same optimum."""

from collections.abc import Sequence

import numpy as np

from tp_jax.estimation.outcome import Outcome

SAME = 1.0  # chi-square, in units of the misfit


def indistinguishable(a: Outcome, b: Outcome, u_a: np.ndarray, u_b: np.ndarray) -> bool:
    """True where the data cannot tell two outcomes apart.

    Their sums of squares differ by less than one, and so they would if one moved to the other's
    numbers, as the better one's information says. Where the model misses the data by more than
    the noise, it is the misfit that one counts in.

    Args:
        a, b: outcomes of the same windows. u_a, u_b: their unknowns' estimation coordinates.
    """
    if not (np.isfinite(a.cost) and np.isfinite(b.cost)):
        return False
    best = a if a.cost <= b.cost else b
    unit = SAME * max(best.chi2_dof, 1.0)
    d = u_a - u_b
    return abs(a.cost - b.cost) <= unit and float(d @ best.information @ d) <= unit


def groups(outcomes: Sequence[Outcome], coordinates: Sequence[np.ndarray]) -> list[int]:
    """For each outcome the one that stands for it: the best of those it cannot be told from.

    Args:
        outcomes: of the same windows. coordinates: (u,) of each.
    """
    leaders: list[int] = []
    stands = [0] * len(outcomes)
    for i in sorted(range(len(outcomes)), key=lambda i: (outcomes[i].cost, i)):
        alike = (
            j
            for j in leaders
            if indistinguishable(outcomes[j], outcomes[i], coordinates[j], coordinates[i])
        )
        stands[i] = next(alike, i)
        if stands[i] == i:
            leaders.append(i)
    return stands
