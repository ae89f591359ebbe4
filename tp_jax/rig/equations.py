"""Equations of motion of the two bodies, each sliding one way, the other, or at rest.

    B1 a1 = P - F1 + M_T            P = k (f_e - phi1) - c1 v1 + what effects add
    B2 (a1 + a2) = -M_T             M_T = Tv v2 + what effects add + D2

Dry friction is Coulomb's as a set: a body that slides to side s = ±1 has F1 = s L1 (column on
bearing) or D2 = s L2 (rider on column); one at rest has the F1 or D2 that keeps it at rest, as
long as that lies between -L(-1) and +L(+1). Limits L1 = M1, L2 = Ts1 + Tst (1 - exp(-T0 |v2|)),
times what effects make of them, never below zero. No smoothing anywhere.

With a base that moves (angle psi), a1 is relative to it; the column's own acceleration is
a1 + psi''. In general

    a1 = ((1 + recoil) U + reaction M_T) / B1 + w,   a1 + psi'' = (U + reaction M_T) / B1,

U = P - F1, and w the part of -psi'' that no torque on the column causes.
"""

import math
from collections.abc import Callable

from tp_jax.rig.hooks import Hooks, Instant
from tp_jax.rig.parameters import RigParameters

#: t, phi1, phi2, v1, v2, z, side1, side2 -> a1, a2, F1, D2.
Rates = Callable[..., tuple[float, float, float, float]]
#: (instant's side, speed, at rest) -> limit of dry friction [N m].
Limit = Callable[[float, float, bool], float]

FAR = 100.0
"""Exponent of the contact's law at most: a step on trial may go far past a stop, to a speed below
zero whose exponential is no number."""


def equations(
    p: RigParameters, hooks: Hooks, m: Instant, angle: Callable[[float], float], duration: float
) -> tuple[Rates, Limit, Limit]:
    """Accelerations and limits of dry friction of one rig, as functions.

    Args:
        p: its numbers. hooks: what effects add. m: filled at every evaluation, where effects look.
        angle: of the spring's far end [rad] at a time [s].
        duration: over which drifts run from -1/2 to 1/2 [s].
    """
    B1, B2, k, c1, M1, Tv, Tst, T0 = p.B1, p.B2, p.k, p.c1, p.M1, p.Tv, p.Tst, p.T0
    Ts1 = p.Ts1 * max(1.0 + hooks.grip_base, 0.0)
    expm1 = math.expm1
    column, contact = tuple(hooks.column), tuple(hooks.contact)
    bearing, load = tuple(hooks.bearing), tuple(hooks.load)
    grip, ground = tuple(hooks.grip), hooks.ground
    g, r = 1.0 + hooks.recoil, hooks.reaction
    rider, watched = p.has_rider, hooks.on_motion
    both = B2 / (B1 + r * B2)

    def limit1(side: float, speed: float, stuck: bool) -> float:
        if not (bearing or load):
            return M1
        m.side, m.speed, m.stuck = side, speed, stuck
        part = 1.0
        for add in bearing:
            part += add(m)
        limit = M1 * part if part > 0.0 else 0.0
        for add in load:
            limit += add(m)
        return limit

    def limit2(side: float, speed: float, stuck: bool) -> float:
        dry = Ts1 - Tst * expm1(min(-T0 * speed, FAR))
        if not grip:
            return dry
        m.side, m.speed, m.stuck = side, speed, stuck
        part = 1.0
        for add in grip:
            part += add(m)
        return dry * part if part > 0.0 else 0.0

    def rates(t, phi1, phi2, v1, v2, z, side1, side2):
        f = angle(t)
        d = f - phi1
        P = k * d - c1 * v1
        Q = Tv * v2
        w = 0.0
        if watched:
            m.t, m.s = t, t / duration - 0.5
            m.phi1, m.phi2, m.v1, m.v2, m.f, m.d, m.z = phi1, phi2, v1, v2, f, d, z
            for add in column:
                P += add(m)
            for add in contact:
                Q += add(m)
            if ground is not None:
                w = ground(m)
        if side1:
            F1 = side1 * limit1(side1, side1 * v1, False)
            U = P - F1
            if not rider:
                D2 = a2 = 0.0
                a1 = g * U / B1 + w
            elif side2:
                D2 = side2 * limit2(side2, side2 * v2, False)
                MT = Q + D2
                a1 = (g * U + r * MT) / B1 + w
                a2 = -MT / B2 - (U + r * MT) / B1
            else:
                MT = -U * both
                D2 = MT - Q
                a1 = (g * U + r * MT) / B1 + w
                a2 = 0.0
        else:
            a1 = 0.0
            if not rider:
                U = -B1 * w / g
                D2 = a2 = 0.0
            elif side2:
                D2 = side2 * limit2(side2, side2 * v2, False)
                MT = Q + D2
                U = -(r * MT + B1 * w) / g
                a2 = -MT / B2 - (U + r * MT) / B1
            else:
                U = -B1 * w / (g - r * both)
                D2 = -U * both - Q
                a2 = 0.0
            F1 = P - U
        m.pull = U
        return a1, a2, F1, D2

    return rates, limit1, limit2
