"""The double and the single torsion pendulum: equations (16a) and (16b) put together.

State: phi1 (column, relative to the base), phi2 (rider, relative to the column), v1, v2, then the
states of the effects that have any.

    B1 v1' = k (f_e - phi1) - M_L + r M_T          r = 2 as printed (16a), 1 by Newton's third law
    B2 (v1' + v2') = -M_T                          (16b)

With phi2 relative to the column the contact torque does the virtual work -M_T dphi2 only, so the
column receives M_T once. The paper's 2 cannot be seen in angles: it halves B1, k, c1 and M1.

Where an effect lets the base turn with an acceleration psi'', (16a) is that of the column's own
turning, v1' + psi'', and (16b) that of v1' + psi'' + v2'.

All components may be arrays of equal shape; the equations work elementwise.
"""

from abc import abstractmethod
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from tp_jax.model.arrays import AnyArray, as_float
from tp_jax.model.bearing import Bearing
from tp_jax.model.contact import Contact
from tp_jax.model.drive import AbstractDrive
from tp_jax.model.friction import smooth_sign
from tp_jax.model.motion import Motion
from tp_jax.model.sensors import Sensors
from tp_jax.model.spring import LinearSpring

PRINTED_REACTION = 2.0
NEWTON_REACTION = 1.0


class AbstractTorsionPendulum(eqx.Module):
    """Common parts of both pendulums: drive, spring, bearing, sensors, inertia of the column."""

    drive: eqx.AbstractVar[AbstractDrive]
    spring: eqx.AbstractVar[LinearSpring]
    bearing: eqx.AbstractVar[Bearing]
    sensors: eqx.AbstractVar[Sensors]
    B1: eqx.AbstractVar[Array]
    terms: eqx.AbstractVar[tuple]
    drift: eqx.AbstractVar[tuple]

    @property
    def n_states(self) -> int:
        """Number of states: four, and those of the effects."""
        return 4 + sum(term.n_states for term in self.terms)

    def clock_rate(self, t: AnyArray | float) -> Array:
        """True seconds per recorded second."""
        total = jnp.ones_like(t)
        for term in self.terms:
            if term.hook == "clock":
                total = total + term.increment(Motion(t=t))
        return total

    def _driven(self, t: AnyArray, y: tuple) -> Motion:
        """Everything up to the angle of the spring's far end; `t` is true time."""
        phi1, phi2, v1, v2 = y[:4]
        middle, rate = self.drift
        m = Motion(t=t, s=(t - middle) * rate, phi1=phi1, phi2=phi2, v1=v1, v2=v2, z=y[4:])
        m.A = self.drive.amplitude
        m.theta = self.drive.phase(t)
        m.theta = m.theta + self._sum("phase", m)
        m.later = lambda a: self.drive.later(t, a)
        m.k = self.spring.k
        f = self.drive.angle(t, m.theta)
        m.wound = self.spring.winding(f - phi1)
        m.f = f + self._sum("drive", m)
        return m

    def _column_motion(self, t: AnyArray | float, y: tuple) -> Motion:
        """Everything up to the bearing's torque; `t` is recorded time."""
        t = t * self.clock_rate(t)
        m = self._driven(t, y)
        v1 = m.v1
        m.f_rate = lambda: jax.jvp(lambda t: self._driven(t, y).f, (t,), (jnp.ones_like(t),))[1]
        m.d = self.spring.winding(m.f - m.phi1)
        m.spring = self.spring.torque(m.d) + self._sum("spring", m)
        m.M1 = self.bearing.M1
        m.sign1 = smooth_sign(v1, self.bearing.eps)
        m.bearing_dry = m.M1 * m.sign1
        m.bearing_viscous = self.bearing.viscous(v1)
        m.bearing = m.bearing_dry + m.bearing_viscous + self._sum("bearing", m)
        m.B1 = self.B1
        return m

    def _sum(self, hook: str, m: Motion) -> Any:
        """Sum of what the effects add at one place."""
        total, offset = 0.0, 0
        states = m.z
        for term in self.terms:
            if hook in term.hooks:
                m.hook = hook
                m.z = states[offset : offset + term.n_states]
                total = total + term.increment(m)
            offset += term.n_states
        m.z = states
        return total

    def _state_rates(self, m: Motion) -> tuple:
        """Derivatives of the effects' own states, in their order."""
        rates, offset = [], 0
        states = m.z
        for term in self.terms:
            if term.n_states:
                m.z = states[offset : offset + term.n_states]
                rates += list(term.rates(m))
            offset += term.n_states
        m.z = states
        return tuple(rates)

    @abstractmethod
    def motion(self, t: AnyArray | float, y: tuple) -> Motion:
        """All quantities of one instant, accelerations included.

        Args:
            t: recorded time [s]. y: tuple of the state's components, equal shapes.
        """

    def derivative(self, t: AnyArray | float, y: tuple) -> tuple:
        """Derivatives of the state's components with respect to recorded time."""
        m = self.motion(t, y)
        rate = self.clock_rate(t)
        rates = (m.v1, m.v2, m.a1, m.a2, *self._state_rates(m))
        return tuple(rate * jnp.broadcast_to(r, jnp.shape(m.v1)) for r in rates)

    def vector_field(self, t: Array, y: Float[Array, " n"], args: Any = None) -> Array:  # noqa: ARG002
        """The same on one array (n_states,), as diffrax wants it."""
        return jnp.stack(self.derivative(t, tuple(y)))

    def readings(self, t: AnyArray | float, y: tuple) -> tuple[Array, Array]:
        """Returns the readings of the two sensors [rad] in state `y` at recorded time `t`."""
        return self._read(self.motion(t, y))

    def readings_and_rates(self, t: AnyArray, y: tuple) -> tuple[Array, Array, Array, Array]:
        """Returns the readings [rad] and their rates [rad/s], accelerations held.

        A sensor that lags reads some of its body's acceleration. Where that body just sticks, the
        acceleration changes as abruptly as friction is sharp, by more than any reading shows.
        """

        def held(t, y):
            m = self.motion(t, y)
            m.a1, m.a2 = jax.lax.stop_gradient((m.a1, m.a2))
            return self._read(m)

        rates = self.derivative(t, y)
        read, rate = jax.jvp(held, (t, y), (jnp.ones_like(t), rates))
        return *read, *rate

    def _read(self, m: Motion) -> tuple[Array, Array]:
        y1 = m.phi1 + self.sensors.zero1 + self._sum("sensor1", m)
        y2 = m.phi2 + self.sensors.zero2 + self._sum("sensor2", m)
        return y1, y2


class DoubleTorsionPendulum(AbstractTorsionPendulum):
    """Column and rider. Fields: the components, B1 and B2 [kg m^2], reaction factor, effects.

    `terms` are effects with their amplitudes (`tp_jax.effects.Applied`); `drift` = (middle [s],
    rate [1/s]) maps time to s in [-1/2, 1/2] for effects that drift within a recording.
    """

    drive: AbstractDrive
    spring: LinearSpring
    bearing: Bearing
    contact: Contact
    sensors: Sensors = eqx.field(default_factory=Sensors)
    B1: Float[Array, "..."] = eqx.field(converter=as_float, default=1.0)
    B2: Float[Array, "..."] = eqx.field(converter=as_float, default=1.0)
    reaction: Float[Array, "..."] = eqx.field(converter=as_float, default=NEWTON_REACTION)
    terms: tuple = ()
    drift: tuple = (0.0, 0.0)

    def motion(self, t: AnyArray | float, y: tuple) -> Motion:
        """All quantities of one instant, accelerations [rad/s^2] included."""
        m = self._column_motion(t, y)
        m.Ts1 = self.contact.Ts1
        m.sign2 = smooth_sign(m.v2, self.contact.eps)
        m.contact_dry = self.contact.dry(m.v2)
        m.contact_viscous = self.contact.viscous(m.v2)
        m.contact = m.contact_dry + m.contact_viscous + self._sum("contact", m)
        m.B2 = self.B2
        # The rider's own acceleration, negative, is what both equations share: a compiler that
        # fuses them evaluates a sum anew for either, a quotient once.
        rider = m.contact / self.B2
        column = m.spring - m.bearing + self._sum("column", m)
        absolute = column / self.B1 + self.reaction * (self.B2 / self.B1) * rider
        m.a1 = absolute - self._sum("base", m)
        m.a2 = -rider - absolute
        return m


class SingleTorsionPendulum(AbstractTorsionPendulum):
    """The column alone. phi2 and v2 are carried along and stay as they are (zero)."""

    drive: AbstractDrive
    spring: LinearSpring
    bearing: Bearing
    sensors: Sensors = eqx.field(default_factory=Sensors)
    B1: Float[Array, "..."] = eqx.field(converter=as_float, default=1.0)
    terms: tuple = ()
    drift: tuple = (0.0, 0.0)

    def motion(self, t: AnyArray | float, y: tuple) -> Motion:
        """All quantities of one instant, accelerations [rad/s^2] included."""
        m = self._column_motion(t, y)
        m.a1 = (m.spring - m.bearing + self._sum("column", m)) / self.B1 - self._sum("base", m)
        m.a2 = jnp.zeros_like(m.a1)
        # The rider's velocity is not a motion of anything here.
        m.v2 = jnp.zeros_like(m.v2)
        return m
