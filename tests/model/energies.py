"""Energies and powers of a pendulum: what goes in, what is lost, what is stored."""

from typing import NamedTuple

import jax
from jaxtyping import Array, Float

from tp_jax.model.pendulum import AbstractTorsionPendulum, DoubleTorsionPendulum


class Energy(NamedTuple):
    """Energies [J] and powers [W] of one instant.

    kinetic + spring changes at the rate drive_power - bearing_loss - contact_loss (with the
    Newton-consistent reaction and without effects).
    """

    kinetic: Array
    spring: Array
    drive_power: Array
    bearing_loss: Array
    contact_loss: Array

    @property
    def total(self) -> Array:
        """Stored energy [J]."""
        return self.kinetic + self.spring


def energy(model: AbstractTorsionPendulum, t: Float[Array, ""], y: Float[Array, " n"]) -> Energy:
    """Energies and powers in state `y` (n_states,) at time `t` [s].

    The spring's force on the drive times the drive's speed is the power put in. With the printed
    reaction factor 2 the motion is that of the Newton-consistent model with B1, k, c1, M1 halved,
    so the column's part is divided by the factor; otherwise energy would seem to rise undriven.
    """
    m = model.motion(t, tuple(y))
    double = isinstance(model, DoubleTorsionPendulum)
    factor = model.reaction if double else 1.0
    kinetic = 0.5 * model.B1 * m.v1**2 / factor
    contact_loss = 0.0 * m.v1
    if double:
        kinetic = kinetic + 0.5 * model.B2 * (m.v1 + m.v2) ** 2
        contact_loss = m.contact * m.v2
    angle = lambda t: model.drive.angle(t, model.drive.phase(t))  # noqa: E731
    _, speed = jax.jvp(angle, (t,), (t * 0 + 1.0,))
    return Energy(
        kinetic=kinetic,
        spring=model.spring.energy(m.d) / factor,
        drive_power=m.spring * speed / factor,
        bearing_loss=m.bearing * m.v1 / factor,
        contact_loss=contact_loss,
    )
