"""Hard dry friction: what moves between two events, and what an event does.

The law of `tp_jax.model` as its ε grows without end: a body that slides has the sign of its
velocity, s, in its friction; a body that is stuck, s = 0, has whatever torque holds it, up to a
limit. With both signs given the equations are smooth, and their Taylor series follow from one
another by recurrence. All quantities are (L,), one number a lane; derivatives (D, L). Parameters
q are in the order of `scripts._bench.problem.NAMES`, with Newton's reaction.

XLA evaluates a cheap expression anew for each of its readers, and never a quotient (see
`docs/engine.md`): hence the divisions by `one` and `unit`, which are one.
"""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from tp_jax.model.elementary import sine

MARGIN = 1e-9
"""A stuck body leaves where the torque is above its limit by this part of it, so that it does."""

Series = list[Array]
"""Coefficients by rising power of the time."""


class Piece(NamedTuple):
    """Series between two events.

    q1, q2, v1, v2, a1, a2: angles, velocities, accelerations; needed: torque that holds the column
    where it is stuck, else the rider (0 unless that is stuck); drive: k f_e; fade: exp(-T0 |v2|).
    """

    q1: Series
    q2: Series
    v1: Series
    v2: Series
    a1: Series
    a2: Series
    needed: Series
    drive: Series
    fade: Series


def value(c: Series | Array, x: Array) -> Array:
    """The series at x."""
    total = c[-1]
    for m in range(len(c) - 2, -1, -1):
        total = total * x + c[m]
    return total


def with_slope(c: Series | Array, x: Array) -> tuple[Array, Array]:
    """The series and its derivative at x."""
    total, slope = c[-1], 0.0 * x
    for m in range(len(c) - 2, -1, -1):
        slope = slope * x + total
        total = total * x + c[m]
    return total, slope


def series(t: Array, y: list, s1: Array, s2: Array, q: tuple, order: int, one: Array) -> Piece:
    """From state y at time t on, as long as no sign changes."""
    k, A, B1, B2, c1, M1, Tv, Ts1, Tst, T0, omega = q
    turning = jnp.where(s1 == 0.0, jnp.inf, jnp.where(s2 == 0.0, B1 + B2, B1))
    slides = jnp.where(s2 == 0.0, 0.0, 1.0)
    rider = jnp.where(s2 == 0.0, jnp.inf, B2)
    at, ahead = k * A * sine(omega * t) / one, k * A * sine(omega * t + 0.5 * np.pi) / one
    turns = [at, ahead * omega, -at * omega**2, -ahead * omega**3]
    fourth, power, factorial = omega**4 / one, 1.0, 1.0
    p = Piece([y[0]], [y[1]], [y[2]], [y[3]], *([] for _ in range(5)))
    p.fade.append(slides * jnp.exp(-T0 * jnp.abs(y[3])))
    pace = -1.0 / (T0 * s2)  # infinite where the rider is stuck
    for n in range(order):
        factorial *= max(n, 1)
        p.drive.append(turns[n % 4] * power * (1.0 / factorial))
        power = power * fourth if n % 4 == 3 else power
        spring = p.drive[n] - k * p.q1[n]
        contact = Tv * p.v2[n] - s2 * Tst * p.fade[n]
        column = spring - c1 * p.v1[n]
        if n == 0:
            contact, column = contact + s2 * (Ts1 + Tst), column - s1 * M1
        p.a1.append((column + contact) / turning)
        p.a2.append(-(contact / rider) - slides * p.a1[n])
        p.needed.append(jnp.where(s1 == 0.0, spring + contact, -B2 * p.a1[n]))
        for rate, of in ((p.v1, p.q1), (p.v2, p.q2), (p.a1, p.v1), (p.a2, p.v2)):
            of.append(rate[n] * (1.0 / (n + 1)))
        product = sum(p.a2[j] * p.fade[n - j] for j in range(n + 1))
        p.fade.append(product / (pace * (n + 1)))
    return p


def tangents(
    start: list, p: Piece, s1: Array, s2: Array, q: tuple, order: int, one: Array, unit: Array
) -> list[Series]:
    """Series of the derivatives of q1, q2, v1, v2 by ten parameters and four initial states."""
    k, A, B1, B2, c1, _, Tv, _, Tst, T0, _ = q
    slides = jnp.where(s2 == 0.0, 0.0, 1.0)
    by_turning = 1.0 / jnp.where(s1 == 0.0, jnp.inf, jnp.where(s2 == 0.0, B1 + B2, B1))
    by_rider = slides / B2
    slope = [slides * Tst * T0 * fade for fade in p.fade]
    slope[0] = slope[0] + slides * Tv
    slope = [x / one for x in slope]
    none = jnp.zeros_like(one)
    dq1, dq2, dv1, dv2 = ([x] for x in start)
    for n in range(order):
        first = 1.0 if n == 0 else 0.0
        late = sum(p.v2[j] * p.fade[n - j] for j in range(n + 1)) / one
        joint = jnp.where(s2 == 0.0, -p.a1[n], 0.0)
        contact = jnp.stack(
            [none] * 6
            + [slides * p.v2[n], first * s2, s2 * (first - p.fade[n]), Tst * late]
            + [none] * 4
        )
        column = jnp.stack(
            [p.drive[n] / k - p.q1[n], p.drive[n] / A, -p.a1[n], joint, -p.v1[n], -first * s1]
            + [none] * 8
        )
        rider = jnp.stack([none] * 3 + [p.a1[n] + p.a2[n]] + [none] * 10)
        contact = contact + sum(slope[j] * dv2[n - j] for j in range(n + 1))
        a1 = (contact + column - k * dq1[n] - c1 * dv1[n]) * by_turning / unit
        a2 = (-(contact + rider) * by_rider - slides * a1) / unit
        for rate, of in ((dv1[n], dq1), (dv2[n], dq2), (a1, dv1), (a2, dv2)):
            of.append(rate * (1.0 / (n + 1)))
    return [dq1, dq2, dv1, dv2]


def until_event(p: Piece, s1: Array, s2: Array, q: tuple, sign: Array) -> tuple[Series, Series]:
    """Series of each body that fall to zero at its event: velocity, or what still holds it.

    sign: of the torque that holds the stuck one, at the end of the step.
    """
    found = []
    for s, v, limit in ((s1, p.v1, q[5]), (s2, p.v2, q[7])):
        idle = (s == 0.0) & (s1 == 0.0) if s is s2 else jnp.zeros_like(s, bool)
        c = [jnp.where(s == 0.0, -sign * p.needed[m], s * v[m]) for m in range(len(p.a1))]
        c[0] = c[0] + jnp.where(s == 0.0, limit * (1.0 + MARGIN), 0.0)
        found.append([jnp.where(idle, 1.0 if m == 0 else 0.0, x) for m, x in enumerate(c)])
    return found[0], found[1]


def settled(
    t: Array, y: list, s1: Array, s2: Array, left1: Array, left2: Array, q: tuple
) -> tuple[Array, Array]:
    """Signs after an event, of bodies whose velocity is zero; the others keep theirs.

    There is one answer: friction takes what it can, and torques are monotone in velocities. left1,
    left2: whether the body has just been torn loose.
    """
    k, A, B1, B2, c1, M1, Tv, Ts1, Tst, T0, omega = q
    q1, _, v1, v2 = y
    rests1, rests2 = v1 == 0.0, v2 == 0.0
    spring = k * (A * sine(omega * t) - q1)
    contact = Tv * v2 + s2 * (Ts1 + Tst * (1.0 - jnp.exp(-T0 * jnp.abs(v2))))
    held = spring + jnp.where(rests2, 0.0, contact)
    stuck1 = rests1 & (jnp.abs(held) <= M1) & ~left1
    s1 = jnp.where(rests1, jnp.where(stuck1, 0.0, jnp.sign(held)), s1)
    held = -B2 * (spring - c1 * v1 - s1 * M1) / (B1 + B2)
    stuck2 = rests2 & (stuck1 | ((jnp.abs(held) <= Ts1) & ~left2))
    return s1, jnp.where(rests2, jnp.where(stuck2, 0.0, jnp.sign(held)), s2)
