"""Contents of recordings and campaigns, from arrays: no file is needed."""

import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tp_jax.errors import InputError
from tp_jax.recordings import units
from tp_jax.recordings.checks import check_span, check_times, check_values
from tp_jax.recordings.columns import Columns
from tp_jax.recordings.entries import Entry, Known, Model
from tp_jax.recordings.readings import even_times, from_first_row
from tp_jax.recordings.recorded_run import RecordedRun
from tp_jax.recordings.tables import as_numbers, is_dated, is_zoned


def recording_fields(
    t: ArrayLike,
    phi1: ArrayLike,
    phi2: ArrayLike | None = None,
    *,
    omega: float | None = None,
    drive: ArrayLike | None = None,
    forced: bool | None = None,
    name: str = "run",
    t_unit: str = "s",
    angle_unit: str = "rad",
    **more: Any,
) -> dict[str, Any]:
    """The fields of a `RecordedRun`, times and values checked; arguments as of
    `Recording.from_arrays`.

    Raises:
        InputError: the arrays cannot be what they are said to be.
    """
    if forced is None:
        forced = drive is not None or bool(omega)
    if forced and drive is None and not (omega and 0.0 < omega < float("inf")):
        raise InputError(
            f"Recording {name} was forced, but its omega is {omega}; give omega in rad/s, or drive."
        )
    factors = {
        "t": _factor("t_unit", t_unit, units.TIME),
        "phi1": _factor("angle_unit", angle_unit, units.ANGLE),
    }
    factors["phi2"] = factors["phi1"]
    given = {"t": t, "phi1": phi1, "phi2": phi2, "drive": drive}
    file, values = Path(name), {}
    for key, array in given.items():
        if array is not None:
            cells = np.asarray(array)
            column = as_numbers(file, key, cells)
            dates = key == "t" and (cells.dtype.kind in "Mm" or is_dated(cells))
            factor = 1.0 if dates else factors.get(key, 1.0)
            values[key] = column if factor == 1.0 else column * factor
    shapes = {key: column.shape for key, column in values.items()}
    if any(shape != (values["t"].size,) for shape in shapes.values()):
        told = ", ".join(f"{key} {shape}" for key, shape in shapes.items())
        raise InputError(
            f"Recording {name} must have columns of one length and one dimension, but has {told}."
        )
    digest = hashlib.sha256(b"".join(column.tobytes() for column in values.values())).hexdigest()
    finite = bool(np.isfinite(values["t"]).all())
    notes = []
    if finite:
        values["t"], note = from_first_row(values["t"])
        notes += [f"{name}: {each}" for each in note]
    t, quantum = even_times(values["t"], values) if finite else (values["t"], None)
    if quantum is not None:
        values["t"] = t
        notes.append(f"{name}: times are rounded to {quantum:.3g} s, and were made even")
    columns = Columns(
        file,
        values,
        range(values["t"].size),
        None,
        digest,
        dated=is_dated(np.asarray(given["t"])),
        zoned=is_zoned(np.asarray(given["t"])),
    )
    check_times(columns)
    check_span(columns, Entry(name, file, forced), 0, values["t"].size, file)
    check_values(columns, 0, values["t"].size)
    return {
        "name": name,
        "label": name,
        "file": file,
        "t": values["t"],
        "phi1": values["phi1"],
        "phi2": values.get("phi2"),
        "drive": values.get("drive"),
        "forced": forced,
        "omega": omega if forced else None,
        "sha256": digest,
        "span": None,
        "start": None,
        "repeat": None,
        "held_out": False,
        "notes": tuple(notes),
        **more,
    }


def campaign_fields(
    recordings: Sequence[RecordedRun],
    *,
    name: str = "campaign",
    B1: float | None = None,
    B2: ArrayLike | Sequence[float] | None = None,
    k: ArrayLike | Sequence[float] | None = None,
    model: Model | None = None,
) -> dict[str, Any]:
    """The fields of a `Campaign`, checked; arguments as of `Campaign.from_arrays`.

    Raises:
        InputError: they do not make a campaign.
    """
    if not recordings:
        raise InputError(f"Campaign {name} has no recordings; give one or more.")
    labels = [each.label for each in recordings]
    for label in labels:
        if labels.count(label) > 1:
            raise InputError(f"Campaign {name} has two recordings {label}; name them apart.")
    if all(each.held_out for each in recordings):
        raise InputError(f"Campaign {name} has nothing to fit; let held_out be False of some.")
    riders = [each.phi2 is not None for each in recordings]
    if model is None:
        model = "double" if any(riders) else "single"
    if model == "double" and not all(riders):
        label = labels[riders.index(False)]
        raise InputError(f"Recording {label} has no phi2; add it, or give model='single'.")
    if (B2 is not None or k is not None) and B1 is None:
        raise InputError(
            "B2 or k is given, but B1 is not; give it, or 1 if they are per unit of it."
        )
    return {
        "name": name,
        "model": model,
        "B1": B1,
        "B2": _known("B2", B2),
        "k": _known("k", k),
        "sample_rate": None,
        "recordings": tuple(recordings),
        "folder": Path(),
    }


def arrays_of(frame: Any, columns: Mapping[str, str] | None) -> dict[str, np.ndarray]:
    """The columns t, phi1, phi2 and drive of a DataFrame, those that are there.

    Args:
        frame: of pandas, or one with the same methods.
        columns: name here -> name in the frame, where they differ.

    Raises:
        InputError: a column is missing.
    """
    names = {each: each for each in ("t", "phi1", "phi2", "drive")} | dict(columns or {})
    there = [str(each) for each in frame.columns]
    for name in ("t", "phi1", *(columns or {})):
        if names.get(name) not in there:
            raise InputError(
                f"There is no column {names.get(name)!r} for {name} among {', '.join(there)}; name "
                "it, as in columns={'phi1': 'angle'}."
            )
    return {key: frame[name].to_numpy() for key, name in names.items() if name in there}


def _factor(argument: str, unit: str, table: Mapping[str, float]) -> float:
    name = units.named(unit, table)
    if name is None:
        raise InputError(f"Argument {argument} must be one of {', '.join(table)}, but is {unit!r}.")
    return table[name]


def _known(argument: str, value: ArrayLike | Sequence[float] | None) -> Known | None:
    """A number that is fixed, or a pair of any kind, (value, standard deviation)."""
    if value is None:
        return None
    try:
        numbers = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        numbers = np.empty(0)
    if numbers.shape not in ((), (2,)):
        raise InputError(
            f"Argument {argument} must be a number or a pair (value, standard deviation), but is "
            f"{value!r}."
        )
    return Known(*numbers.ravel().tolist())
