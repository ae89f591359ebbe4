"""Coefficients of the linearly implicit method.

RODAS4 of Hairer and Wanner, "Solving Ordinary Differential Equations II" (1996), section IV.7:
six stages, order 4 with an embedded order 3, L-stable, stiffly accurate. It needs the exact
Jacobian and the derivative by time. The least work at errors of 1e-5 rad and below (see
`scripts/bench`), so that whole runs use it.
"""

from typing import NamedTuple

import numpy as np


class StageForm(NamedTuple):
    """A Rosenbrock method without products of the Jacobian (Hairer and Wanner, equation IV.7.25):

    `(1/(gamma h) - J) u_i = f(t + c_i h, y + sum a_ij u_j) + sum C_ij u_j / h + h d_i f_t`.

    a, C: (s, s) strictly lower triangular; c: (s,) times; d: (s,) weights of the derivative by
    time; b, b_error: (s,) weights of the step and of its error.
    """

    gamma: float
    a: np.ndarray
    C: np.ndarray
    c: np.ndarray
    d: np.ndarray
    b: np.ndarray
    b_error: np.ndarray
    order: int


def _rodas4() -> StageForm:
    a, C = np.zeros((6, 6)), np.zeros((6, 6))
    a[1, :1] = (1.544,)
    a[2, :2] = 0.9466785280815826, 0.2557011698983284
    a[3, :3] = 3.314825187068521, 2.896124015972201, 0.9986419139977817
    a[4, :4] = 1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950
    a[5, :5] = *a[4, :4], 1.0
    C[1, :1] = (-5.6688,)
    C[2, :2] = -2.430093356833875, -0.2063599157091915
    C[3, :3] = -0.1073529058151375, -9.594562251023355, -20.47028614809616
    C[4, :4] = 7.496443313967647, -10.24680431464352, -33.99990352819905, 11.70890893206160
    C[5, :5] = (
        8.083246795921522,
        -7.981132988064893,
        -31.52159432874371,
        16.31930543123136,
        -6.058818238834054,
    )
    return StageForm(
        gamma=0.25,
        a=a,
        C=C,
        c=np.array([0.0, 0.386, 0.21, 0.63, 1.0, 1.0]),
        d=np.array([0.25, -0.1043, 0.1035, -0.0362, 0.0, 0.0]),
        b=np.array([*a[4, :4], 1.0, 1.0]),
        b_error=np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0]),
        order=4,
    )


RODAS4 = _rodas4()
