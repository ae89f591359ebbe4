"""Free-run prediction of a run never seen, from a diagnosis."""

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tp_jax.effects import catalogue, laws
from tp_jax.errors import InputError
from tp_jax.estimation.assemble import drive_for, pendulum
from tp_jax.estimation.layout import SENSORS
from tp_jax.model.parameters import BY_NAME
from tp_jax.model.pendulum import AbstractTorsionPendulum, SingleTorsionPendulum
from tp_jax.model.plausible import span
from tp_jax.recordings import local_polynomial
from tp_jax.recordings.drive_noise import without_drive_noise
from tp_jax.recordings.lookup import recording_of
from tp_jax.results.diagnosis import Found
from tp_jax.simulation.solve import Trajectory, simulate


def predict(
    found: Found,
    *,
    omega: float | None = None,
    phi1: float | None = None,
    recording: str | Path | None = None,
    duration: float | None = None,
    rate: float | None = None,
    model: str | None = None,
) -> Trajectory:
    """Predicts the sensors' readings on a run, before or after the causes are added.

    Exactly one of `omega`, `phi1` and `recording` says which run.

    Args:
        found: a diagnosis, or the dictionary of it.
        omega: frequency of a forced run from rest [rad/s].
        phi1: angle from which a decay is released, the motor at rest [rad].
        recording: a file of the campaign whose drive and start are to be used.
        duration: length [s]; that of the recording if None.
        rate: samples per second [Hz]; those of the recording if None.
        model: "before" or "after"; None: after, or before where no cause was accepted.

    Returns:
        A `Trajectory` whose angles are readings (zero offsets and sensor effects included);
        phi2 is None for a single pendulum.

    Raises:
        InputError: in one sentence, what is wrong with the arguments or the diagnosis.
    """
    given = [x is not None for x in (omega, phi1, recording)]
    if sum(given) != 1:
        raise InputError("A prediction needs exactly one of omega, phi1 and recording.")
    for name, x in (("duration", duration), ("rate", rate)):
        if x is not None and not 0.0 < x < np.inf:
            raise InputError(f"The {name} of a prediction must be above zero, but is {x:g}.")
    diagnosis = found if isinstance(found, Mapping) else found.to_dict()
    record = _fit_of(diagnosis, model)
    if recording is not None:
        return _of_recording(diagnosis, record, Path(recording), duration, rate)
    if duration is None or rate is None:
        raise InputError("A prediction needs a duration and a rate; give --duration and --rate.")
    x0 = np.zeros(4)
    if phi1 is not None:
        x0[0] = phi1
    return readings_of(_pendulum_of(record, omega, duration), times(0.0, duration, rate), x0)


def found_pendulum(
    found: Found,
    *,
    omega: float | None = None,
    duration: float = 10.0,
    model: str | None = None,
) -> AbstractTorsionPendulum:
    """The pendulum of a diagnosis, for `tp.simulate`, `tp.sweep` and their derivatives.

    Args:
        found: a diagnosis, or the dictionary of it.
        omega: frequency of the drive [rad/s]; None: the motor stands still.
        duration: of the run [s], over which a drift runs its course.
        model: "before" or "after"; None: after, or before where no cause was accepted.

    Returns:
        The pendulum with the effects that were accepted. `tp.simulate` gives its angles; its
        `readings` have what the sensors say of them.

    Raises:
        InputError: in one sentence, what is wrong with the arguments or the diagnosis.
    """
    if not 0.0 < duration < np.inf:
        raise InputError(f"The duration of a run must be above zero, but is {duration:g}.")
    diagnosis = found if isinstance(found, Mapping) else found.to_dict()
    return _pendulum_of(_fit_of(diagnosis, model), omega, duration)


def _pendulum_of(
    record: Mapping[str, Any], omega: float | None, duration: float
) -> AbstractTorsionPendulum:
    if omega is not None and not record["parameters"].get("A"):
        raise InputError(
            "The diagnosis knows no commanded drive, all its recordings being decays or of a "
            "measured one; leave omega out, and ask for --phi1 or --recording."
        )
    drift = (0.5 * duration, 1.0 / duration)
    return pendulum(record, drive_for(record, omega=omega), None, drift)


def _fit_of(diagnosis: Mapping[str, Any], model: str | None) -> Mapping[str, Any]:
    """The fit before or after, if a pendulum can be made of it."""
    if model not in (None, "before", "after"):
        raise InputError(f"A prediction is by the model 'before' or 'after', not {model!r}.")
    try:
        if model is None:
            model = "before" if diagnosis["fits"]["after"] is None else "after"
        record = diagnosis["fits"][model]
    except (KeyError, TypeError):
        raise InputError(
            f"The diagnosis holds no fit {model or 'after'!r}; write it anew with `tp-jax "
            "diagnose`."
        ) from None
    if record is None:
        raise InputError("The diagnosis accepted no cause, so that it has only a model 'before'.")
    _check_parameters(record["parameters"])
    _check_effects(record)
    return record


def _check_parameters(parameters: Mapping[str, float]) -> None:
    """Sees that a pendulum can have these numbers: with others a run may be finite and nonsense."""
    for name, value in parameters.items():
        if name not in BY_NAME:
            continue
        low, high = span(BY_NAME[name], parameters["B1"])
        # no drive that was commanded is an amplitude of zero; zero may be missed by rounding
        least = low if BY_NAME[name].transform == "log" and name != "A" else -1e-9 * high
        if not least <= value <= high:
            raise InputError(
                f"The diagnosis gives {name} as {value:g} {BY_NAME[name].unit}, but it must lie "
                f"between {low:g} and {high:g}."
            )


def _check_effects(record: Mapping[str, Any]) -> None:
    """Sees that the catalogue has the causes of a fit, and the fit all their numbers."""
    known = {**catalogue(), **laws()}
    for id, numbers in record["effects"].items():
        if id not in known:
            raise InputError(
                f"The diagnosis names the effect {id!r}, which is not in the catalogue; install "
                "or register it first."
            )
        wanted = {x.name for x in (*known[id].amplitudes, *known[id].shapes)}
        if set(numbers) != wanted:
            raise InputError(
                f"The diagnosis must give {id} the numbers {', '.join(sorted(wanted))}, but gives "
                f"it {', '.join(sorted(map(str, numbers))) or 'none'}."
            )


def times(start: float, duration: float, rate: float) -> np.ndarray:
    """Sample times with both ends included."""
    n = round(duration * rate)
    return start + np.arange(n + 1) / rate


def readings_of(model: AbstractTorsionPendulum, t: np.ndarray, x0: np.ndarray) -> Trajectory:
    """A simulated motion with the sensors' readings in place of the angles.

    Args:
        model: with all effects.
        t: times [s].
        x0: (4,) angles [rad] and velocities [rad/s] at the first. What effects remember begins at
            rest, as in the diagnosis' own free runs.

    Raises:
        InputError: the motion cannot be integrated to its end.
    """
    own = np.zeros(model.n_states - x0.size)
    motion = simulate(model, t, np.concatenate([x0, own]))
    states = (motion.phi1, motion.phi2, motion.omega1, motion.omega2)
    # What acts on the motion has done so; the states of its own are not in the trajectory.
    sensing = tuple(term for term in model.terms if term.hook in SENSORS)
    y1, y2 = dataclasses.replace(model, terms=sensing).readings(motion.t, states)
    if not np.isfinite([*states, y1, y2]).all():
        raise InputError(
            "The model of this diagnosis cannot be integrated to the end of the run; check the "
            "numbers under fits, or ask for a shorter run."
        )
    single = isinstance(model, SingleTorsionPendulum)
    return motion._replace(phi1=y1, phi2=None if single else y2)


def _of_recording(diagnosis, record, file: Path, duration, rate) -> Trajectory:
    """Drive and start of a campaign's file; a held-out span of it before a fitted one."""
    data = without_drive_noise(recording_of(file))
    t = data.t
    if duration is not None or rate is not None:
        length = duration if duration is not None else data.duration
        t = times(float(t[0]), length, rate or 1.0 / float(np.median(np.diff(t))))
    if data.measured_drive and t[-1] > data.t[-1] + 1e-9:
        raise InputError(
            f"{file.name} has a measured drive up to {data.t[-1]:g} s, ask for no more than that."
        )
    sine = data.forced and not data.measured_drive
    # a diagnosis of decays alone has no amplitude, one without a measured drive no gain
    known = (
        record["nuisances"].get("gain") if data.measured_drive else record["parameters"].get("A")
    )
    if data.forced and not known:
        kind = "a measured" if data.measured_drive else "a commanded"
        raise InputError(
            f"{file.name} has {kind} drive, of which the diagnosis knows nothing, since none of "
            "its recordings had one; diagnose again with such a recording."
        )
    drive = drive_for(record, omega=data.omega if sine else None, t=data.t, reading=data.drive)
    drift = (record.get("drift") or {}).get(data.label) or data.drift
    middle, rate = drift
    m = pendulum(record, drive, data.label, (middle, rate))
    return readings_of(m, t, _start(diagnosis, record, data))


def _start(diagnosis, record, data) -> np.ndarray:
    """State at the start: as the diagnosis estimated it, or smoothed from the first samples."""
    which = "after" if record is not diagnosis["fits"].get("before") else "before"
    for r in diagnosis.get("recordings") or []:
        start = (r.get("start") or {}).get(which)
        if start and r.get("label") == data.label and r.get("sha256") == data.sha256:
            x0 = np.asarray(start, dtype=float).copy()
            # of samples that were means of several, the first lies half of them later
            begin = data.t[0] if r.get("begin") is None else r["begin"]
            x0[:2] -= (begin - data.t[0]) * x0[2:]
            return x0
    x0, zeros = np.zeros(4), record["nuisances"]
    zero2 = zeros["zero2"]
    own = zero2.get(data.label, float(np.mean(list(zero2.values()))))
    for i, y in enumerate((data.phi1, data.phi2)):
        if y is not None:
            fit = local_polynomial(data.t[:60], y[:60], 1.0, 15)
            x0[i], x0[2 + i] = fit.value[0] - (own if i else zeros["zero1"]), fit.first[0]
    return x0
