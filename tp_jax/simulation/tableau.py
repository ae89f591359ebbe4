"""Coefficients of the linearly implicit method.

ROS34PW2 of Rang and Angermann (2005), "New Rosenbrock W-methods of order 3 for partial
differential algebraic equations of index 1", BIT 45, 761-787: four stages, order 3 with an
embedded order 2, L-stable, stiffly accurate, and of order 3 for *any* matrix in place of the
Jacobian. The last lets the tangents and the effects' own states be integrated with the matrix of
the pendulum alone.
"""

from typing import NamedTuple

import numpy as np


class RosenbrockTableau(NamedTuple):
    """`(I - gamma h J) k_i = f(t + c_i h, y + h sum a_ij k_j) + h J sum g_ij k_j`.

    a, g: (s, s) strictly lower triangular; b, b_error: (s,) weights of the step and of its error.
    """

    gamma: float
    a: np.ndarray
    g: np.ndarray
    b: np.ndarray
    b_error: np.ndarray
    order: int

    @property
    def c(self) -> np.ndarray:
        """Times of the stages."""
        return self.a.sum(axis=1)


def _ros34pw2() -> RosenbrockTableau:
    a = np.zeros((4, 4))
    a[1, 0] = 0.87173304301691801
    a[2, :2] = 0.84457060015369423, -0.11299064236484185
    a[3, 2] = 1.0
    g = np.zeros((4, 4))
    g[1, 0] = -0.87173304301691801
    g[2, :2] = -0.90338057013044082, 0.054180672388095326
    g[3, :3] = 0.24212380706095346, -1.2232505839045147, 0.54526025533510214
    b = np.array([0.24212380706095346, -1.2232505839045147, 1.5452602553351020, 0.435866521508459])
    low = np.array([0.37810903145819369, -0.096042292212423178, 0.5, 0.21793326075422950])
    return RosenbrockTableau(0.43586652150845900, a, g, b, b - low, 3)


ROS34PW2 = _ros34pw2()
