"""Gaps: where samples were lost and the time column jumps."""

from itertools import pairwise

import numpy as np

LONGEST_STEP = 2.5
"""Step, in units of the usual one, above which it is a gap.

One lost sample makes a step of exactly 2, which polynomials and the integration take in their
stride; two in a row make 3. The bound lies in the middle, so that neither a little jitter nor
rounded times decide.
"""

_USUAL = 0.9
"""Share of the steps that are not longer than the usual one.

In evenly sampled data that is the median, as long as fewer than one step in ten is lost. Where
more are long, the recording is sampled that way (in bursts, at two rates, at random times), and
the median would call each of them a gap.
"""


def stretches(t: np.ndarray) -> list[slice]:
    """Cuts times at their gaps.

    Args:
        t: (n,) rising times [s]; they need not be uniform.

    Returns:
        Slices of t, in order, that hold each sample once and no gap; one where there is no gap.
        A stretch may have as little as one sample.

    Example:
        >>> stretches(np.array([0.0, 0.1, 0.3, 0.4, 0.5, 0.6, 1.6, 1.7, 1.8, 1.9, 2.0, 2.1]))
        [slice(0, 6, None), slice(6, 12, None)]
    """
    steps = np.diff(t)
    if not steps.size:
        return [slice(0, np.size(t))]
    usual = np.quantile(steps, _USUAL, method="lower")
    after = np.flatnonzero(steps > LONGEST_STEP * usual) + 1
    edges = [0, *after.tolist(), np.size(t)]
    return [slice(a, b) for a, b in pairwise(edges)]
