"""The rule that sees reversals coming (`tp_jax.simulation.control`) for diffrax."""

from collections.abc import Callable
from typing import NamedTuple

import diffrax
import jax
import jax.numpy as jnp
from diffrax import RESULTS
from jaxtyping import Array

from tp_jax.model.pendulum import AbstractTorsionPendulum
from tp_jax.simulation.control import Control, error_ratio, factor, layers, reversal_rate
from tp_jax.simulation.rodas4 import components
from tp_jax.simulation.runs import SMALLEST, natural_frequency, sign_jumps


class ControllerState(NamedTuple):
    """State of the controller where the next step begins, quantities of shape ().

    f: derivatives of the state; natural: frequency [rad/s]; jumps: see `control.layers`.
    """

    f: tuple
    natural: Array
    jumps: tuple[Array, Array]


class ReversalController(diffrax.AbstractStepSizeController):
    """Step size for a pendulum with dry friction: by the error, and by the time to a reversal.

    For `diffrax.diffeqsolve`, with `Rodas4`. A step's size counts as given where a run is
    differentiated, as in the batch engine.

    Attributes:
        model: the pendulum, which knows its accelerations and the slopes of its friction.
        control: what bounds a step.
    """

    model: AbstractTorsionPendulum
    control: Control
    direction: Array | int

    def __init__(
        self,
        model: AbstractTorsionPendulum,
        tolerance: Array | float = 1e-8,
        control: Control = Control(),  # noqa: B008
        direction: Array | int = 1,
    ):
        """Makes a controller for the motions of one pendulum.

        Args:
            model: the pendulum.
            tolerance: error of an angle in one step [rad].
            control: what else bounds a step; `tolerance` takes its `angle`'s place.
            direction: -1 where time runs backwards; `diffrax.diffeqsolve` says so by itself.
        """
        self.model, self.direction = model, direction
        self.control = control._replace(angle=tolerance)

    def wrap(self, direction):
        """Itself, for time that runs forwards (1) or backwards (-1)."""
        angle = jnp.asarray(self.control.angle)
        return ReversalController(self.model, angle, self.control, jnp.asarray(direction))

    def init(self, terms, t0, t1, y0, dt0, args, func: Callable, error_order):  # noqa: ARG002
        """End of the first step, and the state of the controller."""
        t, y, dt0 = jax.lax.stop_gradient((jnp.asarray(t0, float), components(y0), dt0))
        first = jnp.asarray(1e-3 * (t1 - t0) if dt0 is None else dt0)
        state = ControllerState(
            self._field(t, tuple(y)),
            natural_frequency(self._field, t, y, ()),
            sign_jumps(self._field, t, y, (), self._eps()),
        )
        return t + self._bounded(first, y, state), state

    def adapt_step_size(
        self,
        t0,
        t1,
        y0,
        y1_candidate,
        args,  # noqa: ARG002
        y_error,
        error_order,  # noqa: ARG002
        controller_state,
    ):
        """Says whether a step is kept, and the next; see `diffrax.AbstractStepSizeController`."""
        t0, t1, y, end, error, state = jax.lax.stop_gradient(
            (
                t0,
                t1,
                components(y0),
                components(y1_candidate),
                components(y_error),
                controller_state,
            )
        )
        t1 = jnp.asarray(t1)
        h = t1 - t0
        ratio = error_ratio(
            y, end, error, self._eps(), state.natural, self.control, h, self._layers(state)
        )
        keep = ratio <= 1.0
        choose = lambda a, b: jnp.where(keep, a, b)  # noqa: E731
        t, y = choose(t1, t0), [choose(a, b) for a, b in zip(end, y, strict=True)]
        f = tuple(map(choose, self._field(t1, tuple(end)), state.f))
        state = ControllerState(f, natural_frequency(self._field, t, y, ()), state.jumps)
        size = self._bounded(h * factor(ratio, self.control), y, state)
        result = RESULTS.where(size >= SMALLEST, RESULTS.successful, RESULTS.dt_min_reached)
        return keep, t, t + size, False, state, result

    def _field(self, t: Array, y: tuple, p: tuple = ()) -> tuple:  # noqa: ARG002
        model = jax.tree.map(jax.lax.stop_gradient, self.model)
        return tuple(self.direction * x for x in model.derivative(self.direction * t, y))

    def _eps(self) -> tuple[Array, Array]:
        model = jax.tree.map(jax.lax.stop_gradient, self.model)
        contact = getattr(model, "contact", None)  # a single pendulum has none
        one = model.bearing.eps
        return one, one if contact is None else contact.eps

    def _layers(self, state: ControllerState):
        return layers(list(state.f), state.jumps, state.natural, self.control)

    def _bounded(self, size: Array, y: list[Array], state: ControllerState) -> Array:
        """A step [s] no longer than `size` and than a coming reversal allows."""
        rate = reversal_rate(y, list(state.f), self._eps(), self.control, self._layers(state))
        return 1.0 / jnp.maximum(1.0 / size, rate)
