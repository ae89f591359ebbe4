"""Directions in which nothing is seen, written with as few parameters as possible.

A null space has no basis of its own: any mixture of two directions in it is another one. Those
that people recognise have few parameters and whole coefficients ("all torques by one factor"), so
the basis is reduced to echelon form, single parameters first.
"""

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

ALONE = 1e-6
"""A parameter is null by itself where this much of its axis, or less, lies outside the space."""

NOTHING = 1e-6
"""Coefficients below this part of the largest are none."""

WHOLE = 1e-4
"""Coefficients so close to a whole number are that number."""


@dataclasses.dataclass(frozen=True)
class Direction:
    """A combination of parameters that can change without changing what is measured.

    Attributes:
        coefficients: name -> coefficient in the logarithms, the largest 1. A common factor of two
            parameters is {"a": 1, "b": 1}; a product that alone is known, {"a": 1, "b": -1}.
        kind: "structural": no data of this kind tell it; "practical": these data do not.
        sd: standard deviation along it (of the logarithm of the parameter with coefficient 1),
            given these data; infinite where it is structural.
        removed_by: what fixes it nevertheless ("B1 is given"), or None.
    """

    coefficients: Mapping[str, float]
    kind: str
    sd: float = np.inf
    removed_by: str | None = None

    @property
    def text(self) -> str:
        """Describes the direction in words."""
        c = self.coefficients
        names = list(c)
        if len(names) == 1:
            if self.kind == "structural":
                return f"{names[0]} alone: it has no effect on the motion"
            return f"{names[0]} alone"
        if all(abs(x - 1.0) < WHOLE for x in c.values()):
            return f"{', '.join(names[:-1])} and {names[-1]}: all by one factor"
        parts = [f"{n} by the power {x:+.3g}" for n, x in c.items()]
        return f"{', '.join(parts)} of one factor"

    def to_dict(self) -> dict[str, Any]:
        """Returns the direction as plain numbers."""
        return {
            "parameters": {n: float(x) for n, x in self.coefficients.items()},
            "kind": self.kind,
            "sd_log": float(self.sd) if np.isfinite(self.sd) else None,
            "removed_by": self.removed_by,
            "text": self.text,
        }


def sparse_basis(null: np.ndarray, names: Sequence[str]) -> list[dict[str, float]]:
    """A null space in few parameters.

    Args:
        null: (d, P) orthonormal rows that span it.
        names: of the P parameters.

    Returns:
        d combinations, name -> coefficient, the largest of each 1.
    """
    null = np.atleast_2d(np.asarray(null, float)).reshape(-1, len(names))
    out: list[dict[str, float]] = []
    # what is null all by itself comes first, and out of the rest
    alone = [i for i in range(len(names)) if 1.0 - np.linalg.norm(null[:, i]) ** 2 < ALONE]
    for i in alone:
        out.append({names[i]: 1.0})
    rest = [i for i in range(len(names)) if i not in alone]
    if len(alone) == len(null):
        return out
    # the complement of those axes within the space, then its reduced echelon form
    _, s, v = np.linalg.svd(null[:, rest])
    rows = v[: len(null) - len(alone)] if len(s) else v[:0]
    for row in _echelon(rows):
        row = row / row[np.argmax(np.abs(row))]
        nearest = np.round(row)
        row = np.where(np.abs(row - nearest) < WHOLE, nearest, row)
        out.append({names[i]: float(x) for i, x in zip(rest, row, strict=True) if x != 0.0})
    return out


def _echelon(rows: np.ndarray) -> np.ndarray:
    """Reduced echelon form; pivots are the largest entries that are left."""
    a = rows.copy()
    used: list[int] = []
    for r in range(len(a)):
        size = np.abs(a[r:]).copy()
        size[:, used] = 0.0
        i, j = np.unravel_index(int(np.argmax(size)), size.shape)
        a[[r, r + i]] = a[[r + i, r]]
        a[r] /= a[r, j]
        for other in range(len(a)):
            if other != r:
                a[other] -= a[other, j] * a[r]
        used.append(int(j))
    a[np.abs(a) < NOTHING * np.abs(a).max(axis=1, keepdims=True)] = 0.0
    return a
