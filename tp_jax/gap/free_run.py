"""Free runs: from the state at the start of a recording to its end, never corrected."""

import dataclasses
import functools

import equinox as eqx
import jax
import numpy as np

from tp_jax.estimation.assemble import drive_for, fit_record, pendulum
from tp_jax.estimation.baseline import Setting
from tp_jax.estimation.layout import SENSORS, Values
from tp_jax.estimation.problem import Problem
from tp_jax.estimation.variable_projection import fit
from tp_jax.estimation.windows import Windows
from tp_jax.gap.held_out import carried_over
from tp_jax.model.pendulum import AbstractTorsionPendulum
from tp_jax.recordings import stretches
from tp_jax.simulation.solve import simulate


def start_state(setting: Setting, values: Values, recording: int, horizon: float) -> np.ndarray:
    """State at the start of a recording (4,), estimated on its first window only.

    The window ends at a gap, unless that leaves fewer than eight samples.
    """
    values = carried_over(values, setting)
    p = setting.prepared[recording]
    count = int(np.searchsorted(p.t, p.t[0] + horizon, side="right"))
    count = min(count, stretches(p.t)[0].stop)
    windows = Windows(np.array([recording]), np.array([0]), np.array([max(count, 8)]), horizon)
    problem = Problem(
        setting.layout, setting.prepared, windows, setting.sigma, setting.capacity,
        setting.fixed["B1"], programs=setting.programs,
    )  # fmt: skip
    return fit(problem, values, (), max_iterations=15, relative=1e-6).states[0]


def free_run(
    setting: Setting, values: Values, ids: tuple[str, ...], recording: int, x0: np.ndarray
) -> np.ndarray:
    """Predicted readings of one recording (n, 2) [rad] from its start state (4,) alone."""
    values = carried_over(values, setting)
    r = setting.recordings[recording]
    labels = [q.label for q in setting.recordings]
    record = fit_record(values, ids, labels)
    drive = drive_for(
        record,
        omega=r.omega if r.forced and not r.measured_drive else None,
        t=r.t,
        reading=r.drive,
    )
    drift = (values.get("drift_middle", recording), values.get("drift_rate", recording))
    model = pendulum(record, drive, r.label, drift)
    return run_readings(model, r.t, x0)


def run_readings(model: AbstractTorsionPendulum, t: np.ndarray, x0: np.ndarray) -> np.ndarray:
    """Readings (n, 2) of a simulated motion."""
    return np.asarray(_simulate_readings(model, np.asarray(t), np.asarray(x0)))


@functools.partial(eqx.filter_jit)
def _simulate_readings(model, t, x0):
    own = jax.numpy.zeros(model.n_states - 4)
    motion = simulate(model, t, jax.numpy.concatenate([x0, own]), tolerance=1e-7)
    # As in the windows: what an effect does to the motion is in the states.
    sensing = tuple(term for term in model.terms if term.hook in SENSORS)
    model = dataclasses.replace(model, terms=sensing)
    states = (motion.phi1, motion.phi2, motion.omega1, motion.omega2)
    y1, y2 = model.readings(motion.t, states)
    return jax.numpy.stack([y1, y2], axis=1)
