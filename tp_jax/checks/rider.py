"""Checks that phi2 is the rider's angle against the column, and in the column's sense."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from tp_jax.checks.drive import Driven
from tp_jax.checks.finding import Finding
from tp_jax.checks.harmonics import end_of, fit
from tp_jax.checks.policy import DrivePolicy, RiderPolicy
from tp_jax.recordings import Recording, noise_level


@dataclass(frozen=True)
class Reading:
    """Quantity that phi2 may be instead.

    Attributes:
        relative: H of the file to H of the rider against the column.
        wrong: what phi2 is then.
        mend: what to write for phi2.
    """

    relative: Callable[[complex], complex]
    wrong: str
    mend: str


_MIRRORED = "write scale = -1 for phi2 under [format.columns]"

READINGS = (
    Reading(
        lambda h: h - 1.0,
        "phi2 looks measured against the base and not against the column",
        'write minus = "phi1" for phi2 under [format.columns]',
    ),
    Reading(
        lambda h: -h,
        "phi2 looks mirrored, the rider would gain energy from friction",
        _MIRRORED,
    ),
    Reading(
        lambda h: -h - 1.0,
        "phi2 looks measured against the base, and mirrored",
        'write scale = -1, minus = "phi1" for phi2 under [format.columns]',
    ),
)


@dataclass(frozen=True)
class Dragged:
    """Response of a run's rider: H = phi2/phi1 at the drive's frequency."""

    recording: Recording
    h: complex


def misplaced(h: complex) -> float:
    """Distance of H from the half circle below the real axis on which friction puts it."""
    off = abs(abs(h + 0.5) - 0.5)
    return off if h.imag <= 0.0 else max(off, min(abs(h), abs(h + 1.0), h.imag))


def dragged(
    driven: Sequence[Driven], drive: DrivePolicy, policy: RiderPolicy, moving: float | None = None
) -> list[Dragged]:
    """The runs whose rider moves enough to tell; `moving` in place of the policy's."""
    moving = policy.moving if moving is None else moving
    found = []
    for each in driven:
        recording = each.recording
        if recording.phi2 is None or recording.omega is None or each.share < drive.right:
            continue
        part = end_of(recording.t, drive.part)
        t = recording.t[part]
        phi1 = fit(t, recording.phi1[part], recording.omega, drive.harmonics)
        phi2 = fit(t, recording.phi2[part], recording.omega, drive.harmonics)
        h = phi2.amplitude / phi1.amplitude
        if abs(h) > moving and phi2.share > policy.share:
            found.append(Dragged(recording, h))
    return found


def findings(runs: Sequence[Dragged], policy: RiderPolicy) -> list[Finding]:
    """Says what phi2 looks like where it cannot be the rider against the column."""
    if not runs:
        return []
    if _rms([misplaced(run.h) for run in runs]) <= policy.wrong:
        return []
    off = sorted(runs, key=lambda run: -misplaced(run.h))
    labels = tuple(run.recording.label for run in runs)
    numbers = {"h_real": off[0].h.real, "h_imag": off[0].h.imag}
    rms = {
        reading: _rms([misplaced(reading.relative(run.h)) for run in runs]) for reading in READINGS
    }
    likely = min(rms, key=lambda reading: (rms[reading], READINGS.index(reading)))
    if _sticks(off):  # then it goes with the column to the last bit, which no mirrored one does
        likely = READINGS[0]
    if rms[likely] > policy.right:
        return [
            Finding(
                "rider",
                "doubtful",
                labels,
                f"phi2 is {abs(off[0].h):.2g} times phi1 at an angle of "
                f"{np.degrees(np.angle(off[0].h)):.0f} degrees, which no friction does to a rider",
                "see whether phi2 is measured against the column, and in its sense",
                numbers,
            )
        ]
    mend = _with_scale(likely.mend, runs[0].recording)
    return [Finding("rider", "wrong", labels, likely.wrong, mend, numbers)]


def _with_scale(mend: str, recording: Recording) -> str:
    """The advice for a file whose phi2 has a scale already: the opposite of that."""
    source = recording.sources.get("phi2")
    if source is None or source.scale == 1.0:
        return mend
    if source.scale == -1.0 and mend == _MIRRORED:
        return "remove scale = -1 of phi2 under [format.columns]"
    return mend.replace("scale = -1", f"scale = {-source.scale:.15g}")


def _rms(values: Sequence[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _sticks(runs: Sequence[Dragged]) -> bool:
    """True if phi2 − phi1 does not move in a run where phi2 does."""
    for run in runs:
        t, phi1, phi2 = run.recording.t, run.recording.phi1, run.recording.phi2
        if phi2 is None:
            continue
        noise = np.hypot(noise_level(t, phi1), noise_level(t, phi2))
        if np.std(phi2 - phi1) < 2.0 * noise < 0.1 * np.std(phi2):
            return True
    return False
