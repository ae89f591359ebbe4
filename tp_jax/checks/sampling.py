"""Checks that recordings show the motion: samples, noise, ends of the sensor, decays that decay."""

import numpy as np

from tp_jax.checks import time_units
from tp_jax.checks.finding import Finding
from tp_jax.checks.harmonics import strongest
from tp_jax.checks.policy import ClipPolicy, SamplingPolicy
from tp_jax.recordings import Recording, noise_level
from tp_jax.recordings.clocks import unit_of_step
from tp_jax.recordings.units import TIME


def findings(recording: Recording, policy: SamplingPolicy, clip: ClipPolicy) -> list[Finding]:
    """Finds what is doubtful about one recording; nothing here is certain enough to be refused."""
    label = (recording.label,)
    found = []

    def doubt(kind: str, wrong: str, mend: str, **numbers: float) -> None:
        found.append(Finding(kind, "doubtful", label, wrong, mend, numbers))

    step = float(np.median(np.diff(recording.t)))
    unit = _unit_of_time(recording, step, policy)
    if unit is not None:
        doubt(
            "units",
            f"there are {step:.4g} s between samples, and phi1 swings once in "
            f"{_period(recording):.4g} s, so that the times are probably in "
            f"{time_units.NAMES[unit]}",
            f'write unit = "{unit}" for t under [format.columns]'
            f"{time_units.in_place(time_units.source_of(recording))} if they are",
            step=step,
        )
    if recording.omega is not None:
        period = 2.0 * np.pi / recording.omega
        if period / step < policy.fewest:
            doubt(
                "sampling",
                f"there are {period / step:.2g} samples in a period of the drive, fewer than "
                f"{policy.fewest:g}",
                "record at a higher rate",
                samples=period / step,
            )
        if recording.duration / period < policy.periods:
            doubt(
                "sampling",
                f"it lasts {recording.duration / period:.2g} periods of the drive, fewer than "
                f"{policy.periods:g}",
                "record for longer",
                periods=recording.duration / period,
            )
    width = float(np.ptp(recording.phi1))
    if width > policy.widest and not abs(recording.phi1[-1] - recording.phi1[0]) > 0.5 * width:
        doubt(
            "units",
            f"phi1 spans {width:.3g} rad, {np.degrees(width):.0f} degrees",
            'write unit = "deg" for phi1 and phi2 under [format.columns] if they are degrees',
            span=width,
        )
    noise = noise_level(recording.t, recording.phi1)
    deviation = float(np.std(recording.phi1))
    if deviation < policy.signal * noise:
        doubt(
            "motion",
            f"phi1 moves by {deviation:.2g} rad rms at a noise of {noise:.2g} rad",
            "drive it further, or use a better sensor",
            signal=deviation / noise,
        )
    if not recording.forced:
        third = recording.n // 3
        first, last = np.std(recording.phi1[:third]), np.std(recording.phi1[-third:])
        if last > policy.growing * first and last > policy.signal * noise:
            still = not np.ptp(recording.phi1[:third])  # its deviation need not be quite zero
            growth = np.inf if still else float(last / first)
            moves = f"moves {growth:.2g} times as far at its end as at its beginning"
            doubt(
                "motion",
                "it is said to be a free decay, but "
                + ("does not move in its first third" if still else moves),
                "give omega and forced = true if the motor ran, or a span from the release on",
                growth=growth,
            )
    for name, angle in recording.channels.items():
        times, end = stops(angle, clip)
        if times:
            doubt(
                "clipped",
                f"{name} stops short at {end:.4g} rad {times} times, as where a sensor or its "
                "converter ends",
                "set its range wider, or drive it less far",
                times=times,
                at=end,
            )
    return found


def _period(recording: Recording) -> float:
    """s of a swing, as the drive is said to make it or as it is seen."""
    if recording.omega is not None:
        return 2.0 * np.pi / recording.omega
    return 2.0 * np.pi / strongest(recording.t, recording.phi1)


def _unit_of_time(recording: Recording, step: float, policy: SamplingPolicy) -> str | None:
    """The unit in which a motion too slow for a pendulum would be a usual one; None: as said."""
    period = _period(recording)
    if step <= policy.longest_step and (
        recording.omega is not None or period <= policy.slowest or recording.n < policy.seen
    ):
        return None
    if recording.omega is not None:  # at its omega it may still move too seldom
        part = unit_of_step(step)
    else:
        part = "us" if period * TIME["ms"] > policy.slowest else "ms"
    return part and time_units.over_said(time_units.source_of(recording), TIME[part])


def stops(angle: np.ndarray, policy: ClipPolicy) -> tuple[int, float]:
    """Counts how often an angle stops at its greatest or least value; also returns that value."""
    steps = np.abs(np.diff(angle))
    quantum = float(steps[steps > 0.0].min(initial=np.inf))
    for sign in (1.0, -1.0):
        x = sign * angle
        end = x.max()
        there = np.flatnonzero(np.diff(np.r_[False, x == end, False].astype(int)))
        begins, ends = there[::2], there[1::2]
        times = 0
        for a, b in zip(begins, ends, strict=True):
            if b - a < policy.samples or a < 3:
                continue
            # a turning point of its own is a parabola: half the stay at the speed before it
            speed = (x[a - 1] - x[a - 3]) / 2.0
            times += bool(speed * 0.5 * (b - a) > policy.beyond * quantum)
        if times >= policy.times:
            return times, sign * float(end)
    return 0, 0.0
