"""Torques and errors of sensors that are free in every window, and of which no cause is known.

A torque on the column, one between the two bodies (equal and opposite), an error of either sensor,
a delay between them (times that are off for both are a drive that is late, which is a torque): each
is a short Fourier series in every window, with coefficients of its own there. Whatever acts in one
of these places can be written so, whatever its law; which of them is needed says where the gap
comes from.

What moves has inertia, so the series of a torque may be short; a reading may jump. So there are
other kinds of errors of readings, sources of their own with more harmonics: a sensor's error that
jumps to and fro (all harmonics alike), one that wanders (the higher the smaller, as of a random
walk), one that stutters (the reading of some other time), and times that are off for both.
"""

import dataclasses
from collections.abc import Sequence

import jax.numpy as jnp
import numpy as np

from tp_jax.effects import Amplitude, Effect, Shape
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.layout import Layout, Values
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.estimation.problem import Problem
from tp_jax.model.elementary import sine

HARMONICS = 6  # of a window's length
SHARP = 24  # of a reading's error; no more than a quarter of a window's samples
MOST_OF_A_SOURCE = 2 * SHARP + 2  # columns
MOST_OF_ALL = 4 * HARMONICS + 2 + 7 * MOST_OF_A_SOURCE


class _FreeTorque(Effect):
    """`a cos 2 pi W t + b sin 2 pi W t`"""

    amplitudes = (Amplitude("a", "N m", typical=1e-3), Amplitude("b", "N m", typical=1e-3))
    shapes = (Shape("W", "Hz", (1.0,)),)
    formula = "a cos 2 pi W t + b sin 2 pi W t"

    def increment(self, m, a, b, W):  # type: ignore[override]
        """See the class."""
        angle = 2.0 * jnp.pi * W * m.t
        return a * sine(angle + 0.5 * jnp.pi) + b * sine(angle)


class FreeColumnTorque(_FreeTorque):
    """Free torque on the column alone."""

    id = "free_column_torque"
    location = hook = "column"


class FreeContactTorque(_FreeTorque):
    """Free torque between column and rider."""

    id = "free_contact_torque"
    location = hook = "contact"
    needs = frozenset({"rider"})


@dataclasses.dataclass(frozen=True)
class FreeColumns:
    """Derivatives (w, m, q) of a fit's residuals by what is free, the source of each (q,), and how
    large its coefficient is, compared with others of that source (q,).

    A source is a channel, or one and after a space a kind of error.
    """

    jac: np.ndarray
    source: np.ndarray
    weight: np.ndarray


def free_columns(setting: PreparedCampaign, fit: Fit, harmonics: int | None = None) -> FreeColumns:
    """Returns what is free in each window of a fit, as columns of its Jacobian.

    Args:
        setting: the campaign. fit: to it. harmonics: see `errors_of_readings`.
    """
    effects = (FreeColumnTorque(), FreeContactTorque()) if setting.rider else (FreeColumnTorque(),)
    problem, values = probed_by(fit.problem, fit.values, effects)
    parts, source = [], []
    for j in range(HARMONICS + 1):
        slots = [e.qualified(n) for e in effects for n in (("a", "b") if j else ("a",))]
        rate = {e.qualified("W"): j / problem.windows.horizon for e in effects}
        lin = problem.linearise(values.replace(rate), fit.states, slots)
        parts.append(lin.slots_jac)
        source += [e.location for e in effects for _ in range(2 if j else 1)]
    readings = errors_of_readings(setting, fit, harmonics=harmonics)
    return FreeColumns(
        np.concatenate([_where_read(fit, np.concatenate(parts, axis=2)), readings.jac], axis=2),
        np.concatenate([source, readings.source]),
        np.concatenate([np.ones(len(source)), readings.weight]),
    )


def probed_by(
    problem: Problem, values: Values, effects: Sequence[Effect]
) -> tuple[Problem, Values]:
    """A problem's windows with other effects in place of its own, at null, and the numbers there.

    By a program that has these effects alone.
    """
    layout = Layout(problem.layout.kind, tuple(effects))
    index = values.layout.index
    table = Values.build(layout, values.table.shape[1], {}).table.copy()
    for i, p in enumerate(layout.parameters):
        if p.name in index:
            table[i] = values.table[index[p.name]]
    probed = Problem(
        layout,
        problem.prepared,
        problem.windows,
        problem.capacity,
        problem.B1,
        problem.tolerances,
    )
    return probed, Values(layout, table)


def _where_read(fit: Fit, jac: np.ndarray) -> np.ndarray:
    """Columns, with rows of samples that are not there set to zero in place."""
    rows = fit.linearisation.valid.copy()
    rows[:, -4:] = True  # the prior
    jac[~rows] = 0.0
    return jac


def sources_of_errors(setting: PreparedCampaign, fit: Fit) -> list[str]:
    """The sources that `errors_of_readings` knows, for a fit's windows."""
    sensors = ["sensor1", "sensor2"] if setting.rider else ["sensor1"]
    names = [s + kind for s in sensors for kind in (" wandering", "")]
    if harmonics_of(fit) > HARMONICS:
        names += [s + kind for s in sensors for kind in (" jumping", " stuttering")]
        names += ["clock jumping"] if setting.rider else []
    return [*names, "clock"] if setting.rider else names


def harmonics_of(fit: Fit) -> int:
    """Highest harmonic of a window's length that an error of its readings may have."""
    return min(SHARP, fit.linearisation.n_samples // 4)


def errors_of_readings(
    setting: PreparedCampaign, fit: Fit, only: str | None = None, harmonics: int | None = None
) -> FreeColumns:
    """The same of sensors, and of times: a delay between the two (constant and growing), jitter.

    Args:
        setting: the campaign. fit: to it. only: the source that is wanted, all if None.
        harmonics: the highest; that of the fit's windows if None.
    """
    problem, lin = fit.problem, fit.linearisation
    w, n = problem.windows, lin.n_samples
    used = [c for c in range(2) if c == 0 or setting.rider]
    columns: list[np.ndarray] = []
    source: list[str] = []
    weights: list[float] = []
    since = np.zeros((w.n, n))
    for i in range(w.n):
        t = setting.prepared[w.recording[i]].t[w.first[i] : w.first[i] + w.count[i]]
        since[i, : w.count[i]] = t - t[0]
    turn = np.exp(2j * np.pi * since / w.horizon)
    start_sd = np.array(
        [setting.prepared[r].smooth_sd[f] for r, f in zip(w.recording, w.first, strict=True)]
    )
    velocity, sigma = lin.states[:, :, 2:4], problem.sigma

    def add(name: str, errors: dict, prior: dict | None = None, weight: float = 1.0) -> None:
        if only not in (None, name):
            return
        column = np.zeros((w.n, lin.r.shape[1]))
        for c, error in errors.items():
            column[:, c : 2 * n : 2] = error / sigma[:, [c]]
        # the prior of a window's state is a reading too, if a smoothed one
        for row, error in (prior or {}).items():
            column[:, 2 * n + row] = error / start_sd[:, row]
        columns.append(column)
        source.append(name)
        weights.append(weight)

    ramp = since / w.horizon
    slow = np.full(w.n, 1.0 / w.horizon)
    turned = np.ones_like(turn)
    for j in range((harmonics_of(fit) if harmonics is None else harmonics) + 1):
        rate = 2.0 * np.pi * j * slow
        waves = [(np.real(turned), 0.0 * rate)] + [(np.imag(turned), rate)] * (j > 0)
        turned = turned * turn
        for wave, slope in waves:
            for c in used:
                name = f"sensor{c + 1}"
                prior = {c: wave[:, 0], 2 + c: slope} if j <= HARMONICS else {}
                add(f"{name} wandering", {c: wave}, prior, 1.0 / max(j, 1))
                if j <= HARMONICS:
                    add(name, {c: wave}, prior)
                else:
                    add(f"{name} jumping", {c: wave})
                    add(f"{name} stuttering", {c: velocity[:, :, c] * wave})
            if j > HARMONICS and setting.rider:  # of one sensor alone, it is that one that stutters
                add("clock jumping", {c: velocity[:, :, c] * wave for c in used})
    for c in used:
        add(f"sensor{c + 1} wandering", {c: ramp}, {2 + c: slow})
    if setting.rider:
        gained, first = velocity[:, 1, 1] - velocity[:, 0, 1], since[:, 1]
        # of a single sample between two gaps nothing is known
        acceleration = np.divide(gained, first, out=np.zeros_like(first), where=first > 0.0)
        for delay, growth in ((np.ones_like(since), 0.0 * slow), (ramp, slow)):
            start = -velocity[:, 0, 1] * delay[:, 0]
            rate = -acceleration * delay[:, 0] - velocity[:, 0, 1] * growth
            add("clock", {1: -velocity[:, :, 1] * delay}, {1: start, 3: rate})
    jac = _where_read(fit, np.stack(columns, axis=2))
    problem.whiten(jac)
    return FreeColumns(jac, np.array(source), np.array(weights))
