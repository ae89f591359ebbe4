"""Size of the next step: by the error, and by where friction is about to change its sign.

Nearly all the work of a run with dry friction lies in its reversals. The smoothed sign changes
within |v| of a few 1/eps, microseconds of a run of seconds, and an error estimate learns of that
layer by failing: it shrinks the step over several rejections, or jumps over the layer without
noticing. Where a body slows down, the time of its reversal is known well enough, v/|a|, so the
step is bounded by a part of it beforehand.
"""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array

from tp_jax.model.friction import smooth_sign


class Control(NamedTuple):
    """What bounds a step; numbers or arrays (L,), so that changing them compiles nothing.

    angle: error of an angle in a step [rad]. velocity: error of a velocity, in parts of
    `angle` times the natural frequency. friction: greatest deviation of the smoothed sign from
    its tangent. approach: greatest part of the time left to a reversal. layer: width of the
    layer, in 1/eps. growth, shrink: bounds of a step's change.
    """

    angle: Array | float = 2e-6
    velocity: Array | float = 0.3
    friction: Array | float = 0.2
    approach: Array | float = 0.5
    layer: Array | float = 0.5
    growth: Array | float = 3.0
    shrink: Array | float = 0.1


def reversal_rate(y: list[Array], f: list[Array], eps: tuple[Array, Array], c: Control) -> Array:
    """Inverse of the longest step [1/s] that a coming reversal allows."""
    rate = jnp.zeros_like(y[0])
    for v, a, e in zip(y[2:4], f[2:4], eps, strict=True):
        slowing = v * a < 0.0
        bound = jnp.abs(a) / (c.approach * jnp.abs(v) + c.layer / e)
        rate = jnp.maximum(rate, jnp.where(slowing, bound, 0.0))
    return rate


def error_ratio(
    y: list[Array],
    end: list[Array],
    error: list[Array],
    eps: tuple[Array, Array],
    natural: Array,
    c: Control,
) -> Array:
    """Error of a step against what is allowed; at most 1 for a good one.

    Args:
        y, end: states before and after.
        error: embedded error.
        eps: slopes of the smoothed signs [s].
        natural: natural frequency [rad/s], to compare velocities with angles.
        c: bounds.
    """
    angles = jnp.maximum(jnp.abs(error[0]), jnp.abs(error[1]))
    velocities = jnp.maximum(jnp.abs(error[2]), jnp.abs(error[3])) / (c.velocity * natural)
    worst = jnp.maximum(angles, velocities)
    for x in error[4:]:  # own states of effects are angles or smaller
        worst = jnp.maximum(worst, jnp.abs(x))
    for v, v_end, e in zip(y[2:4], end[2:4], eps, strict=True):
        slope = (2.0 / jnp.pi) * e / (1.0 + (e * v) ** 2)
        bend = (smooth_sign(v_end, e) - smooth_sign(v, e) - slope * (v_end - v)) / c.friction
        # of the same order in the step as the error
        worst = jnp.maximum(worst, c.angle * bend**4)
    return worst / c.angle


def factor(ratio: Array, c: Control) -> Array:
    """Change of the step after one with this error ratio (embedded order 3)."""
    change = jnp.sqrt(jnp.sqrt(0.6561 / jnp.maximum(ratio, 1e-12)))
    return jnp.where(jnp.isfinite(ratio), jnp.clip(change, c.shrink, c.growth), c.shrink)
