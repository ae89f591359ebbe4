"""The motion of the spring's far end, f_e(t) [rad]."""

from abc import abstractmethod
from collections.abc import Sequence

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from tp_jax.model.arrays import AnyArray, Real, as_float
from tp_jax.model.elementary import sine


class AbstractDrive(eqx.Module):
    """A drive gives a phase [rad] at a time, and an angle [rad] at a time and phase.

    They are apart so that an effect can act on the phase (a wrong motor speed) or on the angle
    (a cam that is not round).
    """

    @abstractmethod
    def phase(self, t: Float[AnyArray, "..."]) -> Float[Array, "..."]:
        """Phase theta of the drive [rad]."""

    @abstractmethod
    def angle(self, t: Float[AnyArray, "..."], theta: Float[Array, "..."]) -> Float[Array, "..."]:
        """Angle f_e of the spring's far end [rad]."""

    def later(self, t: Float[AnyArray, "..."], a: Real) -> Float[AnyArray, "..."]:
        """Returns what the angle gains [rad] if a measured drive is read `a` seconds later.

        A sine is commanded, not read: it gains nothing.
        """
        return 0.0 * (t + a)

    @property
    @abstractmethod
    def amplitude(self) -> Float[Array, "..."]:
        """Amplitude of a sine drive [rad], zero for others."""


class SineDrive(AbstractDrive):
    """`f_e = A sin(omega t + offset)`, equation (3b); a motor at rest has A = 0.

    Fields: A [rad], omega [rad/s], offset (the phase at t = 0) [rad].
    """

    A: Float[Array, "..."] = eqx.field(converter=as_float)
    omega: Float[Array, "..."] = eqx.field(converter=as_float)
    offset: Float[Array, "..."] = eqx.field(converter=as_float, default=0.0)

    def phase(self, t):
        return self.omega * t + self.offset

    def angle(self, t, theta):  # noqa: ARG002
        return self.A * sine(theta)

    @property
    def amplitude(self):
        return self.A


class PiecewiseCubicDrive(AbstractDrive):
    """A measured drive: cubic pieces between the samples, up to a gain and an offset.

    Fields: gain [rad per unit of the reading], offset [rad], knots (n,) [s], coefficients
    (4, n - 1) as `scipy.interpolate.CubicSpline.c`, highest power first.
    """

    gain: Float[Array, ""] = eqx.field(converter=as_float)
    offset: Float[Array, ""] = eqx.field(converter=as_float)
    knots: Float[Array, " n"] = eqx.field(converter=as_float)
    coefficients: Float[Array, "4 n-1"] = eqx.field(converter=as_float)

    def phase(self, t):
        return jnp.zeros_like(t)

    def angle(self, t, theta):  # noqa: ARG002
        return self.gain * self._reading(t) + self.offset

    def later(self, t, a):
        # beyond the ends of the record it goes on straight
        at = jnp.clip(t + a, self.knots[0], self.knots[-1])
        ahead = t + a - at
        reading, slope = jax.jvp(self._reading, (at,), (jnp.ones_like(at),))
        beyond = jnp.where(ahead == 0.0, 0.0, slope * ahead)
        return self.gain * (reading + beyond - self._reading(t))

    def _reading(self, t):
        i = jnp.clip(jnp.searchsorted(self.knots, t, side="right") - 1, 0, self.knots.size - 2)
        return cubic(self.coefficients[:, i], t - self.knots[i])

    @property
    def amplitude(self):
        return jnp.zeros(())


class LanewiseDrive(AbstractDrive):
    """Drive of the batch engine: a sine and one cubic piece, side by side, for every lane.

    A commanded lane has gain and offset 0, a measured one A = 0; so both kinds are data of the
    same program. Fields as in `SineDrive` and `PiecewiseCubicDrive`; `piece` is (4, ...), `left`
    the start of the piece [s]. The pieces of a drive that is read later are those of what is read
    then (`later`).
    """

    A: Real
    omega: Real
    offset: Real
    gain: Real
    level: Real
    piece: Float[AnyArray, "4 ..."] | Sequence[Real]
    left: Real

    def phase(self, t):
        return self.omega * t + self.offset

    def angle(self, t, theta):
        reading = cubic(self.piece, t - self.left)
        return self.A * sine(theta) + self.gain * reading + self.level

    def later(self, t, a):
        # The pieces are data, and already those that are read `a` later (`estimation.problem`): of
        # the delay there is only the derivative left.
        x = t - self.left
        slope = (3.0 * self.piece[0] * x + 2.0 * self.piece[1]) * x + self.piece[2]
        return self.gain * slope * (a - jax.lax.stop_gradient(a))

    @property
    def amplitude(self):
        return self.A


def cubic(c: Float[AnyArray, "4 ..."] | Sequence[Real], x: Real) -> Real:
    """Value at `x` of the cubic with coefficients `c`, highest power first."""
    return ((c[0] * x + c[1]) * x + c[2]) * x + c[3]
