"""One pendulum from the numbers of a fit: for free runs and predictions."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from tp_jax import effects as catalogue
from tp_jax.effects import Applied
from tp_jax.estimation.layout import Values
from tp_jax.model.bearing import Bearing
from tp_jax.model.contact import Contact
from tp_jax.model.drive import AbstractDrive, PiecewiseCubicDrive, SineDrive
from tp_jax.model.pendulum import (
    AbstractTorsionPendulum,
    DoubleTorsionPendulum,
    SingleTorsionPendulum,
)
from tp_jax.model.sensors import Sensors
from tp_jax.model.spring import LinearSpring

BASE = ("B1", "B2", "k", "A", "c1", "M1", "Tv", "Ts1", "Ts2", "Tst", "T0")


def fit_record(
    values: Values, ids: Sequence[str], labels: Sequence[str], elsewhere: Values | None = None
) -> dict[str, Any]:
    """Everything a prediction needs, as plain numbers.

    Args:
        values: of a fit.
        ids: effects that are in it.
        labels: of the recordings, in order.
        elsewhere: numbers that any other recording is expected to have, the first of each slot;
            of what belongs to a recording the mean, if they are None.
    """
    double = values.layout.kind == "double"
    names = [n for n in BASE if double or n not in ("B2", "Tv", "Ts1", "Ts2", "Tst", "T0")]
    record: dict[str, Any] = {
        "kind": values.layout.kind,
        "parameters": {n: values.get(n) for n in names},
        "reaction": values.get("reaction"),
        "eps": values.get("eps2"),
        "nuisances": {
            **{n: values.get(n) for n in ("phase", "gain", "level", "preload", "zero1")},
            "zero2": {label: values.get("zero2", i) for i, label in enumerate(labels)},
        },
        "drift": {
            label: [values.get("drift_middle", i), values.get("drift_rate", i)]
            for i, label in enumerate(labels)
        },
        "effects": {},
    }
    for id in ids:
        effect = catalogue.get(id)
        numbers: dict[str, Any] = {}
        for a in effect.amplitudes:
            name = effect.qualified(a.name)
            if a.per_recording:
                numbers[a.name] = {lab: values.get(name, i) for i, lab in enumerate(labels)}
            else:
                numbers[a.name] = values.get(name)
        for s in effect.shapes:
            numbers[s.name] = values.get(effect.qualified(s.name))
        record["effects"][id] = numbers
        own = [a.name for a in effect.amplitudes if a.per_recording]
        if own and elsewhere is not None:
            expected = {name: elsewhere.get(effect.qualified(name), 0) for name in own}
            record.setdefault("elsewhere", {})[id] = expected
    return record


def pendulum(
    record: Mapping[str, Any],
    drive: AbstractDrive,
    label: str | None = None,
    drift: tuple[float, float] = (0.0, 0.0),
) -> AbstractTorsionPendulum:
    """A pendulum from `fit_record`.

    Args:
        record: see `fit_record`.
        drive: how it is driven.
        label: recording whose own numbers are to be used; if None or unknown, what is expected
            of another one, or their mean where that is not told.
        drift: middle [s] and rate [1/s] of the drift's clock.
    """
    p = record["parameters"]
    eps = record["eps"]

    def number(x: Any, expected: float | None = None) -> float:
        if not isinstance(x, Mapping):
            return float(x)
        if label in x:
            return float(x[label])
        return float(np.mean(list(x.values()))) if expected is None else float(expected)

    def of(id: str, numbers: Mapping[str, Any]) -> dict[str, Any]:
        expected = (record.get("elsewhere") or {}).get(id) or {}
        return {n: np.float64(number(x, expected.get(n))) for n, x in numbers.items()}

    terms = tuple(
        Applied(catalogue.get(id), of(id, numbers)) for id, numbers in record["effects"].items()
    )
    nuisances = record["nuisances"]
    shared: dict[str, Any] = dict(
        drive=drive,
        spring=LinearSpring(p["k"], nuisances.get("preload") or 0.0),
        bearing=Bearing(p["c1"], p["M1"], eps),
        sensors=Sensors(nuisances["zero1"], number(nuisances["zero2"])),
        B1=p["B1"],
        terms=terms,
        drift=drift,
    )
    if record["kind"] == "single":
        return SingleTorsionPendulum(**shared)
    contact = Contact(p["Tv"], p["Ts1"], p["Tst"], p["T0"], eps, p["Ts2"])
    return DoubleTorsionPendulum(**shared, contact=contact, B2=p["B2"], reaction=record["reaction"])


def drive_for(
    record: Mapping[str, Any],
    *,
    omega: float | None = None,
    t: np.ndarray | None = None,
    reading: np.ndarray | None = None,
) -> AbstractDrive:
    """A sine at `omega` [rad/s], a measured drive (readings at times t), or a motor at rest."""
    n = record["nuisances"]
    if reading is not None and t is not None:
        c = CubicSpline(t, reading).c
        return PiecewiseCubicDrive(n["gain"], n["level"] - n["zero1"], t, c)
    if omega is None:
        return SineDrive(0.0, 0.0)
    return SineDrive(record["parameters"]["A"], omega, n["phase"])
