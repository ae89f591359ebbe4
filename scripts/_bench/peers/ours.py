"""The package's own engine: the only file that knows how it is called.

Four functions, held to the same arguments and results as every peer's (`peer.Peer`), `motions` for
the scaling and `steps` for the robustness. Replace their insides, and nothing else, when the calls
of the engine change. What may be compiled is compiled in the first call for such shapes, which is
never timed.
"""

import jax
import jax.numpy as jnp
import numpy as np

import tp_jax as tp
from tp_jax.model.presets import double_pendulum
from tp_jax.simulation.control import Control

from ..peer import Peer, cores
from ..problem import NAMES

NAME = "tp-jax"


def _model(parameters, eps):
    return double_pendulum(**dict(zip(NAMES, parameters, strict=True)), eps=eps)


_models = jax.jit(jax.vmap(_model, in_axes=(0, None)))
_one = jax.jit(_model)


def run(parameters, eps, ts, tol):
    """Angles (n, 2) [rad] of one run from rest.

    parameters (11,) in the order of `problem.NAMES`, eps [s], ts (n,) [s], tol: the one number
    that the work-precision diagram varies, whatever the engine makes of it.
    """
    return np.asarray(_run(parameters, eps, ts, tol))


@jax.jit
def _run(parameters, eps, ts, tol):
    motion = tp.simulate(_model(parameters, eps), ts, tolerance=tol)
    return jnp.stack([motion.phi1, motion.phi2], axis=1)


def sweep(table, eps, ts, tol):
    """Angles (lanes, n, 2) of the rows of `table` (lanes, 11), on all cores or on the GPU."""
    done = motions(table, eps, ts, tol)
    return np.stack([done.phi1, done.phi2], axis=-1)


def motions(table, eps, ts, tol, changes=None):
    """The same as a user gets it, `tp_jax.Sweep`; `changes` of `Control` compile nothing anew."""
    control = None if changes is None else Control(*map(jnp.asarray, Control(**changes)))
    return tp.sweep(
        _models(np.asarray(table), eps),
        ts,
        tolerance=tol,
        velocities=False,
        control=control,
    )


def sensitivities(parameters, eps, ts, tol):
    """Derivatives (n, 2, 14) of `run`, columns as in `problem.DIRECTIONS`."""
    found = tp.sensitivities(_one(parameters, eps), ts, tolerance=tol)
    # theirs begin with the initial state
    return np.roll(np.stack([found.phi1, found.phi2], axis=1), -4, axis=2)


def many_sensitivities(table, eps, ts, tol):
    """Returns sensitivities of the rows of `table` as a user gets them, `tp_jax.Sensitivities`."""
    return tp.sensitivities(_models(np.asarray(table), eps), ts, tolerance=tol)


def steps(table, eps, ts, tol):
    """Says if the run of each row of `table` was completed (lanes,), and its steps (lanes,)."""
    done = motions(table, eps, ts, tol)
    finite = np.isfinite(done.phi1).all(axis=1) & np.isfinite(done.phi2).all(axis=1)
    return done.complete & finite, done.steps


def platform() -> str:
    """Says where JAX computes: "cpu", "gpu"."""
    return jax.devices()[0].platform


def make() -> Peer:
    """The peer."""
    return Peer(NAME, run, sweep, sensitivities, threads=cores())
