"""Hooks for hidden effects in the rig: lists of functions, empty on a rig without any."""

from collections.abc import Callable
from dataclasses import dataclass, field


class Instant:
    """State that an effect may look at; the same object all along, filled anew at every instant.

    Attributes:
        t: true time since the start of the run [s]; s: the same from -1/2 to 1/2 over the run.
        phi1, phi2, v1, v2: angles [rad] and velocities [rad/s], phi2 and v2 relative to the column.
        f: angle of the spring's far end [rad]; d = f - phi1: the spring's deflection [rad].
        side: +1 or -1, the sense of sliding for which dry friction is asked; speed: of sliding,
            along it [rad/s]; stuck: whether it is the limit of a body at rest that is asked for.
        pull: all torque on the column but the contact's [N m], known after the accelerations.
        z: states of the effects.
    """

    __slots__ = (
        "d",
        "f",
        "phi1",
        "phi2",
        "pull",
        "s",
        "side",
        "speed",
        "stuck",
        "t",
        "v1",
        "v2",
        "z",
    )

    def __init__(self):
        self.t = self.phi1 = self.phi2 = self.v1 = self.v2 = self.f = self.d = 0.0
        self.side = self.speed = self.pull = 0.0
        self.s = -0.5
        self.stuck = False
        self.z: list[float] = []


Quantity = Callable[[Instant], float]


@dataclass
class Hooks:
    """Additions of the effects of one run.

    Attributes:
        phase: (theta [rad], t) -> theta, applied in turn; detuning: what the motor turns faster
            than commanded [rad/s]; drive: (angle f [rad], theta) -> f, applied in turn.
        column: torques on the column [N m], along phi1.
        bearing: what the bearing's dry friction gains, as a part of M1.
        load: what else the bearing's dry friction gains [N m], zero or more.
        contact: torques between the bodies [N m], against phi2, in equal parts on both.
        grip: what the contact's dry friction gains, as a part of itself.
        grip_base: what Ts1 gains, as a part of itself.
        events: quantities whose change of sign a step must end at.
        limits: (t, h) -> h: the longest step from t on that meets no break in time before its end;
            settles which piece the step is on.
        commits: called at the start of every step with that instant, and whether the rider is at
            rest on the column.
        start: initial values of states; rates: Instant -> their derivatives, each for the states
            that it brought (its offset among all is told to it).
        ground: acceleration of the base [rad/s^2], sign reversed, apart from what `recoil` gives.
        recoil: inertia of the column over that of the base.
        reaction: part of the contact's torque that the column receives.
        sensor1, sensor2: (angle so far [rad], Instant) -> angle that is read.
        delay: how late sensor 2 is read [s]; drive_delay: how late the drive is recorded [s].
        stamps: time on the recorder's clock -> true time [s], applied in turn.
        longest: step [s].
        late: called with the finished drive angle(t) before the run begins.
    """

    phase: list[Callable[[float, float], float]] = field(default_factory=list)
    detuning: float = 0.0
    drive: list[Callable[[float, float], float]] = field(default_factory=list)
    column: list[Quantity] = field(default_factory=list)
    bearing: list[Quantity] = field(default_factory=list)
    load: list[Quantity] = field(default_factory=list)
    contact: list[Quantity] = field(default_factory=list)
    grip: list[Quantity] = field(default_factory=list)
    grip_base: float = 0.0
    events: list[Quantity] = field(default_factory=list)
    limits: list[Callable[[float, float], float]] = field(default_factory=list)
    commits: list[Callable[[Instant, bool], None]] = field(default_factory=list)
    start: list[float] = field(default_factory=list)
    rates: list[Callable[[Instant], tuple[float, ...]]] = field(default_factory=list)
    ground: Quantity | None = None
    recoil: float = 0.0
    reaction: float = 1.0
    sensor1: list[Callable[[float, Instant], float]] = field(default_factory=list)
    sensor2: list[Callable[[float, Instant], float]] = field(default_factory=list)
    delay: float = 0.0
    drive_delay: float = 0.0
    stamps: list[Callable[[float], float]] = field(default_factory=list)
    longest: float = 5e-3
    late: list[Callable[[Callable[[float], float]], None]] = field(default_factory=list)

    @property
    def on_motion(self) -> bool:
        """True if anything but drive, sensors and clock is changed, or steps are cut."""
        return bool(
            self.column
            or self.bearing
            or self.load
            or self.contact
            or self.grip
            or self.start
            or self.ground
            or self.events
            or self.limits
            or self.commits
        )

    def state(self, initial: float) -> int:
        """Adds a state; its place among them."""
        self.start.append(initial)
        return len(self.start) - 1
