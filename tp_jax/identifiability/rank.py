"""Structural identifiability: the rank of the sensitivity matrix over many points.

A parameter, or a combination of some, that changes no measured angle leaves the matrix of
derivatives short of columns, wherever it is evaluated. The program does not know which: it looks
at the singular values at many random points, over several experiments together, and reports the
directions that are null at all of them. Tangents of the engine are exact derivatives of the steps
taken, so that what is null is null to rounding, eight orders below the least that is not.

Sources: Stigter, Molenaar (2015), Automatica 58, 118-124 (rank of the sensitivity matrix and its
null space); Miao, Xia, Perelson, Wu (2011), SIAM Review 53, 3-39.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from tp_jax.identifiability.design import Design
from tp_jax.identifiability.log_derivatives import log_derivatives
from tp_jax.identifiability.null_directions import Direction, sparse_basis

NULL = 1e-13
"""Singular values below this part of the largest are rounding."""

POINTS = 16
SPREAD = 3.0

Progress = Callable[[str, float | None], None]


class Rank(NamedTuple):
    """Result of `rank`.

    names: (P,) parameters, coordinates are their logarithms; designs: labels; points: (J, P)
    values [SI units]; singular_values: (J, P) of the sensitivity matrix [1 per unit of
    logarithm, in units of the noise], largest first; ranks: (J,); joint: (P,) singular values of
    all points together, each point in units of its largest; directions: null at every point;
    weakest: (J, P) rows, the direction at each point that is seen least among those that are.
    """

    names: tuple[str, ...]
    designs: tuple[str, ...]
    points: Float[np.ndarray, "J P"]
    singular_values: Float[np.ndarray, "J P"]
    ranks: Int[np.ndarray, " J"]
    joint: Float[np.ndarray, " P"]
    directions: tuple[Direction, ...]
    weakest: Float[np.ndarray, "J P"]

    @property
    def rank(self) -> int:
        """Rank of the sensitivity matrix at the points taken together."""
        return len(self.names) - len(self.directions)

    @property
    def gap(self) -> float:
        """Least singular value that counts, by the largest that does not: far above 1."""
        below = self.joint[self.rank :]
        largest = max(float(below.max(initial=0.0)), np.finfo(float).tiny)
        return float(self.joint[self.rank - 1]) / largest


def rank(
    designs: Sequence[Design],
    centre: Mapping[str, float],
    names: Sequence[str],
    *,
    points: int = POINTS,
    spread: float = SPREAD,
    seed: int = 0,
    progress: Progress | None = None,
) -> Rank:
    """Rank of the sensitivity matrix of some experiments together, at random points.

    Args:
        designs: the experiments.
        centre: values about which the points lie, by name; all above zero.
        names: parameters whose logarithms are the coordinates.
        points: how many. The first is the centre.
        spread: points are drawn from centre / spread to centre * spread, uniform in the logarithm.
        seed: of the draw.
        progress: called with a stage's name and the part of it that is done.

    Raises:
        ValueError: a centre is not above zero, or no point could be integrated.
    """
    names = tuple(names)
    for n in names:
        if not centre[n] > 0.0:
            raise ValueError(f"Argument `centre` must be above zero, but {n} is {centre[n]:g}.")
    rng = np.random.default_rng(seed)
    draw = rng.uniform(-1.0, 1.0, (points, len(names))) * np.log(spread)
    draw[0] = 0.0
    table = np.array([centre[n] for n in names]) * np.exp(draw)
    factors, kept = [], []
    for j, row in enumerate(table):
        values = {**centre, **dict(zip(names, row.tolist(), strict=True))}
        factor = _factor(designs, values, names)
        if factor is not None:
            factors.append(factor)
            kept.append(j)
        if progress is not None:
            progress("structural identifiability", (j + 1) / len(table))
    if not factors:
        raise ValueError("None of the random points could be integrated.")
    decomposed = [np.linalg.svd(f) for f in factors]
    values = np.array([d[1] for d in decomposed])
    ranks = (values > NULL * values[:, :1]).sum(axis=1)
    # Together: what is null at one point only is none of the structure.
    together = np.concatenate([f / s[0] for f, s in zip(factors, values, strict=True)])
    _, joint, rows = np.linalg.svd(together)
    null = rows[int((joint > NULL * joint[0]).sum()) :]
    directions = tuple(Direction(c, "structural") for c in sparse_basis(null, names))
    weakest = np.array([d[2][r - 1] for d, r in zip(decomposed, ranks, strict=True)])
    labels = tuple(d.label for d in designs)
    return Rank(names, labels, table[kept], values, ranks, joint, directions, weakest)


def _factor(
    designs: Sequence[Design], values: Mapping[str, float], names: Sequence[str]
) -> np.ndarray | None:
    """Triangular factor (P, P) of the sensitivity matrix; None where a run did not end."""
    factor = np.zeros((0, len(names)))
    for design in designs:
        rows = log_derivatives(design, values, names).weighted(design.sigma)
        if not np.isfinite(rows).all():
            return None
        factor = np.linalg.qr(np.concatenate([factor, rows]), mode="r")
    pad = np.zeros((len(names) - len(factor), len(names)))
    return np.concatenate([factor, pad])
