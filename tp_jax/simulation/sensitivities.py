"""Derivatives of a motion by the numbers of its pendulum, and whether to trust them."""

import functools
from collections.abc import Sequence
from typing import NamedTuple

import equinox as eqx
import numpy as np
from jaxtyping import Bool, Float

from tp_jax._compiler import compiler_options
from tp_jax.model.arrays import AnyArray
from tp_jax.model.pendulum import AbstractTorsionPendulum
from tp_jax.simulation.batch import gathered, in_pieces, is_many, lanes
from tp_jax.simulation.control import Control
from tp_jax.simulation.parts import take_apart
from tp_jax.simulation.runs import Ran, integrate
from tp_jax.simulation.solve import Trajectory, checked, samples_per_step

BASE = (
    "spring.k",
    "drive.A",
    "B1",
    "B2",
    "bearing.c1",
    "bearing.M1",
    "contact.Tv",
    "contact.Ts1",
    "contact.Tst",
    "contact.T0",
)
"""The paper's unknowns (11) but Ts2, which has no effect, by their place in the pendulum."""

STATE = ("phi1(0)", "phi2(0)", "omega1(0)", "omega2(0)")

DOUBTFUL = 0.1
"""Estimated relative error from which on a derivative is not to be relied upon."""

CHAOTIC = 1e3
"""Growth of a disturbance of the start from which on no derivative of the run means much."""


WIDTH = 32
"""Lanes side by side on a CPU, with their tangents."""

VECTOR = 4
"""Directions of one run are filled up to a multiple of so many: those left over are computed one by
one, and take longer than a full vector."""


class Sensitivities(NamedTuple):
    """Result of `sensitivities`; of many pendulums every field but names and the times has an
    axis (N,) more, the first.

    motion: the run; names: (D,) what it is differentiated by, the initial state first; phi1,
    phi2: (n, D) derivatives of the angles [rad per unit]; error: (D,) estimated error relative to
    the largest value; growth: the largest factor by which a disturbance of the start has grown
    (an angle's against an angle, a velocity's times the time over which it acted); reliable: (D,)
    False where the error or the growth is too large: the run grazes a reversal, or its horizon is
    beyond what can be predicted. What is not reliable is still the derivative of the numerical
    solution, but a finite change does something else.
    """

    motion: Trajectory
    names: tuple[str, ...]
    phi1: Float[AnyArray, "n D"]
    phi2: Float[AnyArray, "n D"]
    error: Float[AnyArray, " D"]
    growth: float | Float[AnyArray, " N"]
    reliable: Bool[AnyArray, " D"]


def sensitivities(
    model: AbstractTorsionPendulum,
    ts: Float[AnyArray, " n"] | Sequence[float],
    y0: Float[AnyArray, "..."] | None = None,
    *,
    by: Sequence[str] | None = None,
    tolerance: float = 1e-6,
    max_steps: int = 1_000_000,
) -> Sensitivities:
    """Derivatives of both angles by the initial state and by numbers of the model.

    Args:
        model: one pendulum, or many that differ in their numbers, (N,) or shared by all (see
            `sweep`); many at once take a fraction of the time of as many calls.
        ts: times [s], increasing.
        y0: initial state (m,), or of many pendulums (N, m); rest if None.
        by: numbers, by their place in the pendulum ("spring.k", "B2", "terms.0.values.a");
            the paper's unknowns if None.
        tolerance: error of an angle in one step [rad].
        max_steps: a run that needs more attempts is given up.

    Returns:
        `Sensitivities`.

    Raises:
        ValueError: where a name is not the model's, or shapes do not fit.

    Example:
        >>> import numpy as np, tp_jax as tp
        >>> found = tp.sensitivities(tp.presets.get("bench"), np.linspace(0.0, 0.2, 51), by=["B2"])
        >>> found.names[-1], found.phi2.shape, bool(found.reliable.all())
        ('B2', (51, 5), True)
    """
    ts, _ = checked(model, ts, None)
    parts = take_apart(model)
    if by is None:
        by = [name for name in BASE if name in parts.names]
    for name in by:
        if name not in parts.names:
            raise ValueError(
                f"Argument `by` names {name!r}, which the model does not have; "
                f"it has {', '.join(parts.names)}."
            )
    places = np.array([parts.names.index(name) for name in by], int)
    p, states = gathered(parts, y0)
    own = parts.n_states
    control, most = Control(angle=np.asarray(tolerance, float)), np.asarray(max_steps)
    alone = not is_many(parts, y0)
    if alone and by:
        places = np.append(places, np.repeat(places[-1:], -(own + len(by)) % VECTOR))

    def run(index: np.ndarray, active: int, width: int) -> Ran:
        return _compiled()(
            parts.template,
            p[:, index],
            states[:, index],
            ts,
            control,
            places,
            most,
            np.asarray(active),
            width,
        )

    if alone:
        done = run(np.zeros(1, int), 1, 1)
        y, s, error = (np.asarray(x) for x in (done.y, done.s, done.error))
        s, error = s[..., : own + len(by)], error[:, : own + len(by)]
    else:
        many, d = states.shape[1], own + len(by)
        y, s = np.empty((many, ts.size, 4)), np.empty((many, ts.size, 2, d))
        error = np.empty((many, d))
        width = lanes(WIDTH, many)

        def piece(index: np.ndarray, active: int) -> None:
            done = run(index, active, width)
            for whole, its in ((y, done.y), (s, done.s), (error, done.error)):
                whole[index[:active]] = np.asarray(its)[:active]

        in_pieces(piece, many, width=width, bytes_each=y[0].nbytes + s[0].nbytes)
    span = float(ts[-1] - ts[0])
    unit = np.array([1.0, 1.0, span, span] + [1.0] * (own - 4))
    growth = (np.abs(s[..., :own]).max(axis=(1, 2)) / unit).max(axis=1)
    reliable = (error < DOUBTFUL) & np.isfinite(error) & (growth < CHAOTIC)[:, None]
    names = (*STATE, *(f"state {i}" for i in range(4, own)), *by)
    if alone:
        motion = Trajectory(np.asarray(ts), *y[0].T)
        return Sensitivities(
            motion, names, s[0, :, 0], s[0, :, 1], error[0], float(growth[0]), reliable[0]
        )
    motion = Trajectory(np.asarray(ts), *np.moveaxis(y, 2, 0))
    return Sensitivities(motion, names, s[:, :, 0], s[:, :, 1], error, growth, reliable)


@functools.cache
def _compiled():
    """`_run` on a processor's full width."""
    # equinox hands such options on to `jax.jit`; its overloads do not tell of them
    options = compiler_options()
    return eqx.filter_jit(_run, compiler_options=options)  # pyright: ignore[reportCallIssue]


def _run(template, p, y0, ts, control, places, max_steps, active, width) -> Ran:
    parts = take_apart(template)
    q = tuple(p)
    return integrate(
        parts.field,
        q,
        y0,
        ts,
        (q[parts.eps[0]], q[parts.eps[1]]),
        control,
        directions=places,
        tangent_velocities=False,
        width=width,
        per_step=samples_per_step(ts.size),
        max_steps=max_steps,
        active=active,
    )
