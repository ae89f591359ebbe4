"""Tables of the page with a row for each recording."""

from typing import Literal

from tp_jax.report.figures import curves
from tp_jax.report.formatting import MISSING, angles, duration, percent
from tp_jax.report.tables import Table, made
from tp_jax.results.diagnosis import CHANNELS, DiagnosisRecord


def runs(diagnosis: DiagnosisRecord) -> Table | None:
    """Each held-out recording by itself, from the points of its curves."""
    free = _errors_of(diagnosis, "curves")
    windowed = _errors_of(diagnosis, "residuals")
    states = diagnosis.states
    rows = []
    for run, channel in dict.fromkeys([*free, *windowed]):
        found = [of.get((run, channel), {}).get(s) for of in (windowed, free) for s in states]
        floor = diagnosis.noise_floor.get(channel)
        rows.append((run or MISSING, CHANNELS[channel], *angles([*found, floor])))
    kinds = [f"{kind}, {state}" for kind in ("windows", "free run") for state in states]
    if len(states) == 1:
        kinds = ["windows", "free run"]
    return made(("Held-out recording", "angle", *kinds, "noise"), rows, *range(2, 7))


def _errors_of(
    diagnosis: DiagnosisRecord, key: Literal["curves", "residuals"]
) -> dict[tuple[str, str], dict[str, float | None]]:
    """rms [rad] before and after of each recording and channel with `curves` or `residuals`."""
    found: dict[tuple[str, str], dict[str, float | None]] = {}
    for run in curves.drawable(getattr(diagnosis, key)):
        for curve in curves.curves_of(run):
            floor = diagnosis.noise_floor.get(curve.channel)
            for state in ("before", "after"):
                if key == "curves":
                    size = curves.rms(curves.error(curve, state))
                else:  # in units of the noise
                    size = curves.rms(getattr(curve, state))
                    size = None if size is None or floor is None else size * floor
                found.setdefault((run.recording, curve.channel), {})[state] = size
    return found


def data(diagnosis: DiagnosisRecord) -> Table | None:
    """The recordings, how they were driven, what they were used for, and what is gone there."""
    rows = []
    gone = diagnosis.gap.shrink_by_recording
    for run in diagnosis.recordings:
        drive = "measured drive" if run.omega is None else f"{run.omega:.4g} rad/s"
        used = {True: "held out, never fitted", False: "fitted", None: MISSING}[run.held_out]
        rows.append(
            (
                run.label,
                "free decay" if run.forced is False else drive,
                duration(run.duration),
                MISSING if run.samples is None else f"{run.samples:,.0f}",
                used,
                *((percent(gone.get(run.label)),) if gone else ()),
            )
        )
    head = ("Recording", "driven at", "length", "samples", "used")
    return made((*head, "gap gone, not fitted") if gone else head, rows, 2, 3, 5)
