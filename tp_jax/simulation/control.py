"""Size of the next step: by the error, and by where friction is about to change its sign.

Nearly all the work of a run with dry friction lies in its reversals. The smoothed sign changes
within |v| of a few 1/eps, microseconds of a run of seconds, and an error estimate learns of that
layer by failing: it shrinks the step over several rejections, or jumps over the layer without
noticing. Where a body slows down, the time of its reversal is known well enough, v/|a|, so the
step is bounded by a part of it beforehand.

Inside the layer an acceleration need not mean that a reversal comes: what a step leaves of it there
dies out within microseconds, and the body creeps on. It comes only if the acceleration exceeds
what the slope of the friction takes back on the way to zero.

A body that something far stronger than its friction turns round, such as a stiff spring, passes the
layer in a nanosecond. It cannot come to rest there, and what its velocity can be wrong by, if the
layer is jumped over, is the jump of its acceleration times the step. Where that is within what a
step's error may be, nothing is resolved (not for tangents, which would miss what the layer does to
them).
"""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array

from tp_jax.model.arrays import AnyArray
from tp_jax.model.friction import smooth_sign


class Control(NamedTuple):
    """Bounds of a step; numbers or arrays (L,), so that changing them compiles nothing.

    angle: error of an angle in a step [rad]. velocity: error of a velocity, in parts of
    `angle` times the natural frequency. friction: greatest deviation of the smoothed sign from
    its tangent. approach: greatest part of the time left to a reversal. layer: width of the
    layer, in 1/eps. creep: part of what the slope takes back that an acceleration must have to
    mean a reversal. crossing: error that jumping over a layer may make, in parts of that of a
    velocity; 0: none is jumped over. growth, shrink: bounds of a step's change.
    """

    angle: AnyArray | float = 2e-6
    velocity: AnyArray | float = 0.3
    friction: AnyArray | float = 0.2
    approach: AnyArray | float = 0.5
    layer: AnyArray | float = 0.5
    leap: AnyArray | float = 0.75
    near: AnyArray | float = 5.0
    creep: AnyArray | float = 0.5
    crossing: AnyArray | float = 0.65
    growth: AnyArray | float = 3.0
    shrink: AnyArray | float = 0.1


class Layers(NamedTuple):
    """Behaviour of the layers of the two bodies, as far as it is known.

    jumps: by how much a sign changes the accelerations [rad/s²]. harmless: longest step [s] that
    may jump over a layer, 0 where the body may come to rest. weight: error of a velocity that a
    step which does makes per second, against what is allowed.
    """

    jumps: tuple[Array, Array]
    harmless: list[Array]
    weight: list[Array]


def layers(f: list[Array], jumps: tuple[Array, Array], natural: Array, c: Control) -> Layers:
    """Says which layers may be jumped over.

    Args:
        f: derivatives of the state.
        jumps: by how much the sign of each velocity changes the accelerations [rad/s²].
        natural: natural frequency [rad/s].
        c: bounds.
    """
    allowed = c.velocity * natural * c.angle
    harmless, weight = [], []
    for a, jump in zip(f[2:4], jumps, strict=True):
        # twice: the other body's friction may change the acceleration too
        turned = (jnp.abs(a) > 2.0 * jump) & (c.crossing > 0.0)
        harmless.append(jnp.where(turned, c.crossing * allowed / jnp.maximum(jump, 1e-300), 0.0))
        weight.append(jnp.where(turned, jump / allowed, jnp.inf))
    return Layers(jumps, harmless, weight)


def reversal_rate(
    y: list[Array],
    f: list[Array],
    eps: tuple[Array, Array],
    c: Control,
    known: Layers | None = None,
) -> Array:
    """Inverse of the longest step [1/s] that a coming reversal allows.

    known: the layers; None: every slowing body may be about to reverse.
    """
    rate = jnp.zeros_like(y[0])
    for i, (v, a, e) in enumerate(zip(y[2:4], f[2:4], eps, strict=True)):
        slowing = v * a < 0.0
        bound = jnp.abs(a) / (c.approach * jnp.abs(v) + c.layer / e)
        if known is not None:
            slope = known.jumps[i] * e / (jnp.pi * (1.0 + (e * v) ** 2))
            slowing = slowing & (jnp.abs(a) > c.creep * slope * jnp.abs(v))
            # far from its layer a body may come close to it in one step
            leap = jnp.maximum(c.leap * jnp.abs(v) - c.near / e, 1e-300)
            bound = jnp.minimum(jnp.minimum(bound, jnp.abs(a) / leap), 1.0 / known.harmless[i])
        rate = jnp.maximum(rate, jnp.where(slowing, bound, 0.0))
    return rate


def error_ratio(
    y: list[Array],
    end: list[Array],
    error: list[Array],
    eps: tuple[Array, Array],
    natural: Array,
    c: Control,
    h: Array | None = None,
    known: Layers | None = None,
) -> Array:
    """Error of a step against what is allowed; at most 1 for a good one.

    Args:
        y, end: states before and after.
        error: embedded error.
        eps: slopes of the smoothed signs [s].
        natural: natural frequency [rad/s], to compare velocities with angles.
        c: bounds.
        h: the step [s]; needed with `known`.
        known: the layers; None: none may be jumped over.
    """
    angles = jnp.maximum(jnp.abs(error[0]), jnp.abs(error[1]))
    velocities = jnp.maximum(jnp.abs(error[2]), jnp.abs(error[3])) / (c.velocity * natural)
    worst = jnp.maximum(angles, velocities)
    for x in error[4:]:  # own states of effects are angles or smaller
        worst = jnp.maximum(worst, jnp.abs(x))
    for i, (v, v_end, e) in enumerate(zip(y[2:4], end[2:4], eps, strict=True)):
        slope = (2.0 / jnp.pi) * e / (1.0 + (e * v) ** 2)
        off = smooth_sign(v_end, e) - smooth_sign(v, e) - slope * (v_end - v)
        bend = (off / c.friction) ** 4  # of the same order in the step as the error
        if known is not None:
            assert h is not None
            bend = jnp.minimum(bend, known.weight[i] * h)
        worst = jnp.maximum(worst, c.angle * bend)
    return worst / c.angle


def factor(ratio: Array, c: Control) -> Array:
    """Change of the step after one with this error ratio (embedded order 3)."""
    change = jnp.sqrt(jnp.sqrt(0.6561 / jnp.maximum(ratio, 1e-12)))
    return jnp.where(jnp.isfinite(ratio), jnp.clip(change, c.shrink, c.growth), c.shrink)
