"""Tables of the page with a row for each recording."""

from collections.abc import Mapping
from typing import Any

from tp_jax.report import reading
from tp_jax.report.figures import curves
from tp_jax.report.formatting import MISSING, angles, duration, percent
from tp_jax.report.tables import Table, made


def runs(diagnosis: Mapping[str, Any]) -> Table | None:
    """Each held-out recording by itself, from the points of its curves."""
    free = _errors_of(diagnosis, "curves")
    windowed = _errors_of(diagnosis, "residuals")
    states = reading.states(diagnosis)
    rows = []
    for run, channel in dict.fromkeys([*free, *windowed]):
        found = [of.get((run, channel), {}).get(s) for of in (windowed, free) for s in states]
        floor = reading.value(diagnosis, "noise_floor", channel)
        rows.append((run or MISSING, reading.CHANNELS[channel], *angles([*found, floor])))
    kinds = [f"{kind}, {state}" for kind in ("windows", "free run") for state in states]
    if len(states) == 1:
        kinds = ["windows", "free run"]
    return made(("Held-out recording", "angle", *kinds, "noise"), rows, *range(2, 7))


def _errors_of(diagnosis: Mapping[str, Any], key: str) -> dict[tuple[str, str], dict]:
    """rms [rad] before and after of each recording and channel with `curves` or `residuals`."""
    found: dict[tuple[str, str], dict] = {}
    for entry in curves.drawable(diagnosis, key):
        for curve in curves.curves_of(entry):
            place = reading.text(entry, "recording"), curve.channel
            for state in ("before", "after"):
                if key == "curves":
                    size = curves.rms(curves.error(curve, state))
                else:  # in units of the noise
                    floor = reading.value(diagnosis, "noise_floor", curve.channel)
                    size = curves.rms(getattr(curve, state))
                    size = None if size is None or floor is None else size * floor
                found.setdefault(place, {})[state] = size
    return found


def data(diagnosis: Mapping[str, Any]) -> Table | None:
    """The recordings, how they were driven, what they were used for, and what is gone there."""
    rows = []
    gone = reading.table(diagnosis, "gap", "shrink_by_recording")
    for run in reading.rows(diagnosis, "recordings"):
        omega = reading.value(run, "omega")
        drive = "measured drive" if omega is None else f"{omega:.4g} rad/s"
        if run.get("forced") is False:
            drive = "free decay"
        used = {True: "held out, never fitted", False: "fitted"}.get(run.get("held_out"), MISSING)  # type: ignore[arg-type]
        length, samples = reading.value(run, "duration"), reading.value(run, "samples")
        label = reading.text(run, "label") or MISSING
        part = reading.value(gone, label)
        rows.append(
            (
                label,
                drive,
                MISSING if length is None else duration(length),
                MISSING if samples is None else f"{samples:,.0f}",
                used,
                *((MISSING if part is None else percent(part),) if gone else ()),
            )
        )
    head = ("Recording", "driven at", "length", "samples", "used")
    return made((*head, "gap gone, not fitted") if gone else head, rows, 2, 3, 5)
