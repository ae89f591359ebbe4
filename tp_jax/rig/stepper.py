"""One step of Dormand and Prince's method of order 5(4), written out for the two bodies.

Source: Dormand, Prince (1980), J. Comp. Appl. Math. 6, 19-26. Plain floats: for four components
this is faster than arrays. States of effects, mostly none, go along in a list.
"""

from collections.abc import Callable
from typing import NamedTuple

from tp_jax.rig.equations import Rates


class End(NamedTuple):
    """End of a step, and what acts there, before anything switches.

    h [s]; angles [rad], velocities [rad/s], accelerations [rad/s^2], dry torques [N m]; z and its
    derivatives dz; error: of the step, 1 where it is just tolerated.
    """

    h: float
    phi1: float
    phi2: float
    v1: float
    v2: float
    z: list[float]
    a1: float
    a2: float
    F1: float
    D2: float
    dz: list[float]
    error: float


# rad, rad/s, of the value: tolerated in one step; a run of 10 s is then right to 1e-9 rad
ANGLE, SPEED, RELATIVE = 4e-12, 8e-11, 4e-11

A21 = 1 / 5
A31, A32 = 3 / 40, 9 / 40
A41, A42, A43 = 44 / 45, -56 / 15, 32 / 9
A51, A52, A53, A54 = 19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729
A61, A62, A63, A64, A65 = 9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656
A71, A73, A74, A75, A76 = 35 / 384, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84
E1, E3, E4, E5, E6, E7 = (
    71 / 57600,
    -71 / 16695,
    71 / 1920,
    -17253 / 339200,
    22 / 525,
    -1 / 40,
)
C2, C3, C4, C5 = 1 / 5, 3 / 10, 4 / 5, 8 / 9


def stepper(rates: Rates, state_rates: Callable[[], list[float]]) -> Callable[..., End]:
    """A step as a function.

    Args:
        rates: accelerations. state_rates: derivatives of the states, right after `rates`.

    Returns:
        f(h, t, phi1, phi2, v1, v2, z, a1, a2, dz, side1, side2) -> End; a1, a2 and dz are those of
        the start.
    """

    def step(h, t, p, q, v, w, z, a, b, dz, side1, side2):
        z2 = z3 = z4 = z5 = z6 = z7 = z
        d3 = d4 = d5 = d6 = d7 = dz
        if z:
            z2 = [x + h * A21 * k for x, k in zip(z, dz, strict=True)]
        v2, w2 = v + h * A21 * a, w + h * A21 * b
        x = h * A21
        a2, b2, _, _ = rates(t + C2 * h, p + x * v, q + x * w, v2, w2, z2, side1, side2)
        if z:
            d2 = state_rates()
            z3 = [x + h * (A31 * k + A32 * k2) for x, k, k2 in zip(z, dz, d2, strict=True)]
        v3, w3 = v + h * (A31 * a + A32 * a2), w + h * (A31 * b + A32 * b2)
        a3, b3, _, _ = rates(
            t + C3 * h,
            p + h * (A31 * v + A32 * v2),
            q + h * (A31 * w + A32 * w2),
            v3,
            w3,
            z3,
            side1,
            side2,
        )
        if z:
            d3 = state_rates()
            z4 = [
                x + h * (A41 * k + A42 * k2 + A43 * k3)
                for x, k, k2, k3 in zip(z, dz, d2, d3, strict=True)
            ]
        v4 = v + h * (A41 * a + A42 * a2 + A43 * a3)
        w4 = w + h * (A41 * b + A42 * b2 + A43 * b3)
        a4, b4, _, _ = rates(
            t + C4 * h,
            p + h * (A41 * v + A42 * v2 + A43 * v3),
            q + h * (A41 * w + A42 * w2 + A43 * w3),
            v4,
            w4,
            z4,
            side1,
            side2,
        )
        if z:
            d4 = state_rates()
            z5 = [
                x + h * (A51 * k + A52 * k2 + A53 * k3 + A54 * k4)
                for x, k, k2, k3, k4 in zip(z, dz, d2, d3, d4, strict=True)
            ]
        v5 = v + h * (A51 * a + A52 * a2 + A53 * a3 + A54 * a4)
        w5 = w + h * (A51 * b + A52 * b2 + A53 * b3 + A54 * b4)
        a5, b5, _, _ = rates(
            t + C5 * h,
            p + h * (A51 * v + A52 * v2 + A53 * v3 + A54 * v4),
            q + h * (A51 * w + A52 * w2 + A53 * w3 + A54 * w4),
            v5,
            w5,
            z5,
            side1,
            side2,
        )
        if z:
            d5 = state_rates()
            z6 = [
                x + h * (A61 * k + A62 * k2 + A63 * k3 + A64 * k4 + A65 * k5)
                for x, k, k2, k3, k4, k5 in zip(z, dz, d2, d3, d4, d5, strict=True)
            ]
        v6 = v + h * (A61 * a + A62 * a2 + A63 * a3 + A64 * a4 + A65 * a5)
        w6 = w + h * (A61 * b + A62 * b2 + A63 * b3 + A64 * b4 + A65 * b5)
        a6, b6, _, _ = rates(
            t + h,
            p + h * (A61 * v + A62 * v2 + A63 * v3 + A64 * v4 + A65 * v5),
            q + h * (A61 * w + A62 * w2 + A63 * w3 + A64 * w4 + A65 * w5),
            v6,
            w6,
            z6,
            side1,
            side2,
        )
        if z:
            d6 = state_rates()
            z7 = [
                x + h * (A71 * k + A73 * k3 + A74 * k4 + A75 * k5 + A76 * k6)
                for x, k, k3, k4, k5, k6 in zip(z, dz, d3, d4, d5, d6, strict=True)
            ]
        p7 = p + h * (A71 * v + A73 * v3 + A74 * v4 + A75 * v5 + A76 * v6)
        q7 = q + h * (A71 * w + A73 * w3 + A74 * w4 + A75 * w5 + A76 * w6)
        v7 = v + h * (A71 * a + A73 * a3 + A74 * a4 + A75 * a5 + A76 * a6)
        w7 = w + h * (A71 * b + A73 * b3 + A74 * b4 + A75 * b5 + A76 * b6)
        a7, b7, F1, D2 = rates(t + h, p7, q7, v7, w7, z7, side1, side2)
        error = max(
            abs(E1 * v + E3 * v3 + E4 * v4 + E5 * v5 + E6 * v6 + E7 * v7)
            / (ANGLE + RELATIVE * abs(p7)),
            abs(E1 * w + E3 * w3 + E4 * w4 + E5 * w5 + E6 * w6 + E7 * w7)
            / (ANGLE + RELATIVE * abs(q7)),
            abs(E1 * a + E3 * a3 + E4 * a4 + E5 * a5 + E6 * a6 + E7 * a7)
            / (SPEED + RELATIVE * abs(v7)),
            abs(E1 * b + E3 * b3 + E4 * b4 + E5 * b5 + E6 * b6 + E7 * b7)
            / (SPEED + RELATIVE * abs(w7)),
        )
        if z:
            d7 = state_rates()
            # states of effects are angles, speeds or torques: the looser of the two
            for x, k, k3, k4, k5, k6, k7 in zip(z7, dz, d3, d4, d5, d6, d7, strict=True):
                e = abs(E1 * k + E3 * k3 + E4 * k4 + E5 * k5 + E6 * k6 + E7 * k7)
                error = max(error, e / (SPEED + RELATIVE * abs(x)))
        return End(h, p7, q7, v7, w7, z7, a7, b7, F1, D2, d7, h * error)

    return step
