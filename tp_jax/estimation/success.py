"""Success rate of a search from random starts, and the cost of a success."""

import dataclasses
from collections.abc import Sequence

import numpy as np
from scipy.stats import binomtest


@dataclasses.dataclass(frozen=True)
class Success:
    """reached, of: starts; probability; ci95: Wilson's interval of it; expected_evaluations: to the
    best optimum, failures on the way included; None where no start reached it."""

    reached: int
    of: int
    probability: float
    ci95: tuple[float, float]
    expected_evaluations: float | None

    def to_dict(self) -> dict:
        """Returns the counts for JSON."""
        return {**dataclasses.asdict(self), "ci95": list(self.ci95)}


def success(reached: Sequence[bool], evaluations: Sequence[float]) -> Success:
    """Counts starts that reached the best, and estimates what a success costs.

    The expected number of evaluations until the first success, starts being repeated until then,
    is estimated by all evaluations over all successes.

    Source: Wilson (1927), J. Am. Stat. Assoc. 22:209; Auger and Hansen (2005), CEC, p. 1777
    (expected running time).

    Args:
        reached: (n,) by start.
        evaluations: (n,) by start, as if it had run alone.

    Example:
        >>> found = success([True, True, False, True], [10, 12, 20, 14])
        >>> found.reached, found.of, round(found.expected_evaluations, 1)
        (3, 4, 18.7)
    """
    hits, n = int(np.sum(reached)), len(reached)
    low, high = binomtest(hits, n).proportion_ci(method="wilson")
    expected = float(np.sum(evaluations)) / hits if hits else None
    return Success(hits, n, hits / n, (float(low), float(high)), expected)
