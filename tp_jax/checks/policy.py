"""Rules that decide about recordings: every threshold with its unit and its reason.

At hand were 85 forced runs of clean virtual rigs and 339 of rough ones, with 50 to 1000 samples a
second, 2 to 12 recordings and coloured noise; two free decays and a wheel from laboratories.
"""

import dataclasses


@dataclasses.dataclass(frozen=True)
class DrivePolicy:
    """Thresholds for whether a forced run moves at the frequency that is said.

    Attributes:
        part: of a run, at its end, that is looked at: starting up is over in it.
        harmonics: of the drive's frequency that count, itself among them.
        right: share of phi1's variance at them above which nothing is said. Good runs have at
            least 0.83 (clean ones 0.988); clean ones with milliseconds read as seconds 0.006 at
            most, with Hz read as rad/s 0.09.
        fundamental: of `right`, the share at the frequency itself below which a harmonic of it is
            the drive's: dry friction, a square wave, has a ninth of its variance at the third.
        wrong: share below which another frequency is looked for.
        other: share that another frequency must have to be the one that the run was driven at.
        near: part by which a unit's factor may miss it; the motor need not turn as commanded.
        periods: of the drive that the part looked at must hold for a frequency to be seen; with
            fewer the fundamental alone counts.
        steady: part by which the amplitude may differ between both halves; what dies out is the
            pendulum's own swing, whose frequency is nobody's mistake.
    """

    part: float = 0.6
    harmonics: int = 3
    right: float = 0.7
    fundamental: float = 0.1
    wrong: float = 0.3
    other: float = 0.9
    near: float = 0.03
    periods: float = 2.0
    steady: float = 0.03


@dataclasses.dataclass(frozen=True)
class RiderPolicy:
    """Thresholds for whether phi2 can be the rider's angle against the column.

    A rider that friction drags along has H = phi2/phi1, at the drive's frequency, on the half
    circle |H + 1/2| = 1/2 below the real axis, whatever the law of friction: it takes energy and
    stores none. Measured against the base it is H + 1, mirrored -H.

    Attributes:
        moving: |H| below which the rider sticks and tells nothing.
        share: of phi2's variance at the drive's frequency and two harmonics, below which H says
            little.
        wrong: distance of H from where it can be, rms over runs, above which phi2 is something
            else; no good run is further than 0.20, delays and crosstalk of sensors included.
        right: distance, rms, up to which another reading of phi2 is the right one.
    """

    moving: float = 0.05
    share: float = 0.5
    wrong: float = 0.25
    right: float = 0.15


@dataclasses.dataclass(frozen=True)
class UnitPolicy:
    """Thresholds for whether an angle is in the unit that is said.

    Attributes:
        clear: least cosine of the angle between H and the real axis' negative half for the
            distance of H to tell anything; beyond it a little phase makes much of it.
        above: part of |H| that may lie above the real axis, by phase errors of sensors.
        near: factor by which a rider may miss the half circle; degrees and gons are alike to it.
        larger: times that H must be too far for another unit; mirrored or against the base it is
            3 times at most.
        at_rest: times that the noise of a body at rest may be less than that of one that moves, and
            that a motion must exceed its noise not to be one of a body at rest.
        alike: factor by which the noise of two sensors of one rig may differ.
    """

    clear: float = 0.3
    above: float = 0.15
    near: float = 1.35
    larger: float = 10.0
    at_rest: float = 20.0
    alike: float = 2.0


@dataclasses.dataclass(frozen=True)
class ClipPolicy:
    """Thresholds for whether an angle is cut off where the sensor or its converter ends.

    Attributes:
        samples: equal ones in a row, at the greatest or the least angle, that may be a stop.
        times: that the angle must stop there.
        beyond: quanta by which the motion would have gone on; at a turning point of its own it
            goes on by two at most.
    """

    samples: int = 4
    times: int = 3
    beyond: float = 10.0


@dataclasses.dataclass(frozen=True)
class SamplingPolicy:
    """Thresholds for whether a recording shows the motion.

    Attributes:
        fewest: samples in a period of the drive; with fewer the motion is guessed at.
        periods: of the drive that a forced run should last; it takes some to start up.
        longest_step: s between samples; no torsion pendulum at hand is so slow, and
            milliseconds read as seconds are.
        slowest: s of a swing; those of all pendulums at hand last less than a tenth of it.
        seen: samples from which a swing is looked for.
        signal: standard deviation of phi1, in those of its noise, below which little can be told.
        widest: rad that phi1 spans, a whole turn; springs at hand were wound by 5.5, and small
            angles in degrees span more.
        growing: of a decay's amplitude, last third over first, that a decay does not have.
    """

    fewest: float = 8.0
    periods: float = 3.0
    longest_step: float = 0.5
    slowest: float = 60.0
    seen: int = 200
    signal: float = 5.0
    widest: float = 6.3
    growing: float = 1.2


@dataclasses.dataclass(frozen=True)
class StartPolicy:
    """Thresholds for whether runs begin at times of their own.

    Attributes:
        phase: rad of the drive by which the beginnings of two runs differ.
        part: of a period at the beginning in which a run from rest has not yet moved.
        samples: that there must be in it.
        noise: levels of noise within which a column is at rest.
        way: of phi1's standard deviation that it may have gone; one that swings goes further,
            about its turning points too.
    """

    phase: float = 0.3
    part: float = 0.1
    samples: int = 3
    noise: float = 5.0
    way: float = 0.04


@dataclasses.dataclass(frozen=True)
class CheckPolicy:
    """All of them."""

    drive: DrivePolicy = DrivePolicy()
    rider: RiderPolicy = RiderPolicy()
    unit: UnitPolicy = UnitPolicy()
    clip: ClipPolicy = ClipPolicy()
    start: StartPolicy = StartPolicy()
    sampling: SamplingPolicy = SamplingPolicy()
