"""What the tests of effects with a memory share: the bench with one of them, and its runs."""

import functools
from collections.abc import Mapping

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from scipy.integrate import odeint

from tests.reference import BENCH
from tp_jax.effects import Applied, Effect, catalogue
from tp_jax.model import presets
from tp_jax.model.pendulum import DoubleTorsionPendulum
from tp_jax.simulation import simulate

IDS = (
    "base_compliance",
    "bearing_presliding",
    "column_cable",
    "contact_presliding",
    "drive_backlash",
    "spring_hysteresis",
)

#: Both bodies reverse, and no slip of the rider is a near thing.
OMEGA = 22.0
TS = np.arange(501) / 250.0


def effect(id: str) -> Effect:
    """An effect by its id."""
    return catalogue()[id]


def middle(id: str) -> dict[str, float]:
    """Its shape constants, each from the middle of its grid."""
    return {s.name: s.grid[len(s.grid) // 2] for s in effect(id).shapes}


def amplitude(id: str) -> str:
    """Name of its only amplitude."""
    (only,) = effect(id).amplitudes
    return only.name


def bench(id: str = "", values: Mapping[str, float] | None = None, **changes):
    """The bench's pendulum, with an effect or without, and with some of its numbers changed."""
    numbers = BENCH | dict(omega=OMEGA) | changes
    terms = ()
    if id:
        terms = (Applied(effect(id), {n: jnp.asarray(float(x)) for n, x in values.items()}),)
    return presets.double_pendulum(**numbers, terms=terms)


def angles(model: DoubleTorsionPendulum, ts=TS, y0=None, **options) -> np.ndarray:
    """Its run: (n, 2) rad."""
    motion = simulate(model, ts, y0, **options)
    return np.stack([motion.phi1, motion.phi2], axis=1)


@functools.cache
def _field(id: str):
    """Rates of (state, its derivative by the amplitude at null), for SciPy; shapes are data."""
    (a,), shapes = effect(id).amplitudes, [s.name for s in effect(id).shapes]
    model = bench(id, {a.name: 0.0} | middle(id))
    places = [lambda m: m.drive.omega, *(_value(n) for n in [a.name, *shapes])]

    @jax.jit
    def field(t, both, omega, constants):
        def rates(y, amplitude):
            numbers = (omega, amplitude, *constants)
            own = eqx.tree_at(lambda m: [place(m) for place in places], model, numbers)
            return jnp.stack(own.derivative(t, tuple(y)))

        y, s = both.reshape(2, -1)
        return jnp.concatenate(jax.jvp(rates, (y, jnp.zeros(())), (s, jnp.ones(()))))

    return field


def _value(name: str):
    return lambda model: model.terms[0].values[name]


@functools.cache
def _direction(id: str, constants: tuple[float, ...], omega: float) -> np.ndarray:
    field, n = _field(id), 4 + effect(id).n_states
    numbers = jnp.asarray(omega), tuple(jnp.asarray(x) for x in constants)
    found = odeint(
        lambda t, y: np.asarray(field(t, y, *numbers)),
        np.zeros(2 * n),
        TS,
        tfirst=True,
        rtol=1e-8,
        atol=1e-10,
        mxstep=1_000_000,
        hmax=5e-3,
    )
    return found[:, n : n + 2]


def direction(id: str, shapes: Mapping[str, float], omega: float = OMEGA) -> np.ndarray:
    """Derivative of the bench's run (n, 2) by the amplitude at null, integrated by SciPy."""
    return _direction(id, tuple(shapes[s.name] for s in effect(id).shapes), omega)


def cosine(a: np.ndarray, b: np.ndarray) -> float:
    """Of the angle between two changes of a run."""
    return float(np.sum(a * b) / np.sqrt(np.sum(a * a) * np.sum(b * b)))
