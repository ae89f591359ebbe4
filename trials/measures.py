"""Shares and means with their 95 % intervals."""

import itertools
import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy import stats

CONFIDENCE = 0.95
DRAWS = 5000


def share(answers: Sequence[bool]) -> dict[str, Any]:
    """Part of yes among answers, with Wilson's interval; nulls where there are none."""
    n = len(answers)
    if n == 0:
        return {"value": None, "n": 0, "ci95": None}
    yes = sum(map(bool, answers))
    ends = stats.binomtest(yes, n).proportion_ci(CONFIDENCE, method="wilson")
    return {"value": yes / n, "n": n, "ci95": [float(ends.low), float(ends.high)]}


STATED = (0.0, 0.5, 0.8, 0.9, 0.99, 1.0)  # ends of the bins of stated probabilities


def reliability(answers: Sequence[tuple[float, bool]]) -> list[dict[str, Any]]:
    """Stated probabilities against how often they were right, in bins of `STATED`.

    Args:
        answers: probability that was stated, whether it was right.

    Returns:
        A row for each bin (its lower end counts to it, and 1 to the last): from, to, n; stated:
        their mean; right: the share, with ci95. Nulls in an empty one.
    """
    rows = []
    for low, high in itertools.pairwise(STATED):
        mine = [(p, yes) for p, yes in answers if low <= p < high or p == high == STATED[-1]]
        found = share([yes for _, yes in mine])
        stated = float(np.mean([p for p, _ in mine])) if mine else None
        rows.append(
            {
                "from": low,
                "to": high,
                "n": found["n"],
                "stated": stated,
                "right": found["value"],
                "ci95": found["ci95"],
            }
        )
    return rows


def mean(values: Sequence[float], seed: int = 0) -> dict[str, Any]:
    """Mean with an interval from resampling (percentiles); none from fewer than two values."""
    x = np.asarray(values, dtype=float)
    if x.size == 0:
        return {"value": None, "n": 0, "ci95": None}
    ci95 = None
    if x.size > 1:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # all values the same
            found = stats.bootstrap(
                (x,),
                np.mean,
                confidence_level=CONFIDENCE,
                n_resamples=DRAWS,
                method="percentile",
                rng=np.random.default_rng(seed),
            ).confidence_interval
        ci95 = [float(found.low), float(found.high)]
    return {"value": float(x.mean()), "n": int(x.size), "ci95": ci95}
