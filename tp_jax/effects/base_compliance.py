"""The housing gives way, so that bearing and spring hook move with the load.

The reaction of spring and bearing turns the base by psi = a p. What is integrated is p, the base's
motion at a = 1, which is there at amplitude zero too; its second state is q = p' / w, w = 2 pi W,
so that both are angles. The column's angle is the one relative to the base.

Where a window begins, p and q follow from the past (`past`), from a base at rest where the
recording begins. They forget with exp(-zeta w t): half a second to two at the smaller damping.
"""

import jax
import jax.numpy as jnp

from tp_jax.effects.base import Amplitude, Effect, Shape


class BaseCompliance(Effect):
    """`psi'' = -2 zeta w psi' - w^2 psi - a (T_spring - M_L) / B1, v1' = ... - psi''`"""

    id = "base_compliance"
    location = "base"
    hook = "base"
    # B1 / B_base: a base that is lighter than its column is none
    amplitudes = (Amplitude("a", "1", typical=0.1, lower=0.0, upper=1.0),)
    shapes = (
        # Above 10 Hz the base follows the load at once, and hardly differs from one frequency to
        # the next; below it answers what drive and slips contain.
        Shape("W", "Hz", (5.0, 6.0, 7.0, 8.5, 11.0, 16.0, 40.0), continuous=True),
        Shape("zeta", "1", (0.02, 0.1)),
    )
    n_states = 2
    formula = "psi'' = -2 zeta w psi' - w^2 psi - a (T_spring - M_L) / B1, v1' = ... - psi''"
    source = "Section 6 of the paper; a base of one mode"
    looks_like = "ripple of the column at a frequency of its own after every jerk"
    remedy = "bolt the housing to something heavy and stiff"
    by_hand = "press on the housing while the column swings, and see whether phi1 changes"

    def increment(self, m, a, W, zeta):  # type: ignore[override]
        """See the class."""
        w = 2.0 * jnp.pi * W
        return a * w * self._second(m, w, zeta)

    def rates(self, m, W, zeta, **_):  # type: ignore[override]
        """See the class."""
        w = 2.0 * jnp.pi * W
        return w * m.z[1], self._second(m, w, zeta)

    def past(self, m, W, zeta, **_):  # type: ignore[override]
        """See the class."""
        w = 2.0 * jnp.pi * W
        return oscillation(m.t, -_reaction(m) / w**2, w, zeta)

    def resolved(self, omega, step):  # noqa: ARG002
        """Four samples in a period of the slowest base."""
        return 4.0 * step * min(self.shapes[0].grid) <= 1.0

    def _second(self, m, w, zeta):
        """q' [rad/s]."""
        p, q = m.z
        return -2.0 * zeta * w * q - w * p - _reaction(m) / w


def _reaction(m):
    """`(T_spring - M_L) / B1` [rad/s^2]."""
    return (m.spring - m.bearing) / m.B1


@jax.jit
def oscillation(t, target, w, zeta):
    """Angle, and rate over w, of `p'' = -2 zeta w p' - w^2 (p - target)` from rest at zero.

    Exact for a target that goes straight from sample to sample: each stretch is a damped rotation
    about a point that goes along.

    Args:
        t: (n,) times [s].
        target: (n,) where the spring of the base has no tension [rad].
        w: frequency [rad/s]; zeta: damping ratio, below 1.

    Returns:
        p, q (n,) [rad].
    """
    h = w * jnp.diff(t)
    slope = jnp.diff(target) / h
    # the particular solution at both ends of a stretch
    first = target[:-1] - 2.0 * zeta * slope
    beta = jnp.sqrt(1.0 - zeta**2)
    decay = jnp.exp(-zeta * h)
    c, s = decay * jnp.cos(beta * h), decay * jnp.sin(beta * h) / beta
    turn = jnp.stack([jnp.stack([c + zeta * s, s], -1), jnp.stack([-s, c - zeta * s], -1)], -2)
    begins = jnp.stack([first, slope], -1)
    ends = jnp.stack([first + slope * h, slope], -1)
    moved = ends - jnp.einsum("nij,nj->ni", turn, begins)

    def go(x, change):
        x = change[0] @ x + change[1]
        return x, x

    start = jnp.zeros(2)
    _, x = jax.lax.scan(go, start, (turn, moved))
    p, q = jnp.concatenate([start[None], x]).T
    return p, q
