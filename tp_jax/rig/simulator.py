"""The virtual rig: what a laboratory's rig would do, hidden effects included.

    rig = VirtualRig(effects={"contact_stribeck": 0.5}, seed=1)
    rig.start(omega=13.09)
    phi1, phi2 = rig.advance(0.004)

Made to put the diagnosis of the package to the test, and therefore without anything of its model:
dry friction is Coulomb's, a stuck body rests exactly (`tp_jax.rig.motion`), every effect is
written anew (`tp_jax.rig.effects`).
"""

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import replace
from zlib import crc32

import numpy as np
from numpy.typing import ArrayLike

from tp_jax.errors import InputError
from tp_jax.rig.drive import drive
from tp_jax.rig.effects import Hidden, hide
from tp_jax.rig.hooks import Hooks, Instant
from tp_jax.rig.motion import Motion
from tp_jax.rig.parameters import BENCH, RigParameters
from tp_jax.rig.segment import Segment

DURATION = 10.0  # s: of a run, unless it is said


class VirtualRig:
    """One rig on which runs are made one after the other.

    Attributes:
        parameters: its numbers.
        amplitude: of its drive [rad]; may be set, for the runs that begin after.
        effects: id of each hidden effect -> its sizes; see `tp_jax.rig.effects.catalogue`.
        shapes: id of each hidden effect -> its shape constants.
        run_values: of the run in progress, id -> values of the effects that differ from run to run.
        taken: true times of the samples of the last whole run (`run`) [s].
    """

    def __init__(
        self,
        parameters: RigParameters = BENCH,
        effects: Mapping[str, float | Sequence[float]] | None = None,
        seed: int = 0,
        shapes: Mapping[str, float] | None = None,
    ):
        """A rig at rest.

        Args:
            parameters: its numbers.
            effects: id -> size, or sizes where the effect has several (missing ones are 0).
            seed: of whatever is random in effects: the same seed and the same runs in the same
                order give the same readings.
            shapes: "id.name" -> shape constant of an effect; its usual value if absent.

        Raises:
            InputError: there is no such effect or shape constant, too many sizes are given, or an
                effect needs a rider where there is none.
        """
        self.parameters = parameters
        self.amplitude = parameters.A
        self._hidden: tuple[Hidden, ...] = hide(effects or {}, shapes or {})
        for each in self._hidden:
            if each.effect.needs_rider and not parameters.has_rider:
                raise InputError(f"Effect {each.effect.id} needs a rider, but the rig's B2 is 0.")
        self.effects = {each.effect.id: each.sizes for each in self._hidden}
        self.shapes = {each.effect.id: dict(each.shapes) for each in self._hidden}
        self.run_values: dict[str, tuple[float, ...]] = {}
        self.taken: list[float] = []
        self._seed, self._runs = seed, 0
        self.start()

    def start(
        self,
        *,
        omega: float | None = None,
        release: float | None = None,
        duration: float = DURATION,
        run_values: Mapping[str, Sequence[float]] | None = None,
    ) -> None:
        """Begins a run at t = 0, from rest.

        Args:
            omega: the drive runs at this frequency [rad/s] from phase 0 on, phi1 = 0 at first.
            release: the column is let go at this angle [rad], the motor stands at neutral.
                Neither: everything stands at zero.
            duration: of the run [s], over which drifts run their course.
            run_values: id -> values of effects that differ from run to run; drawn if absent.

        Raises:
            InputError: both omega and release are given, or one of the numbers cannot be.
        """
        if omega is not None and release is not None:
            raise InputError("A run is either driven or released: give omega or release, not both.")
        for name, value in dict(omega=omega, release=release, duration=duration).items():
            if value is not None and not np.isfinite(value):
                raise InputError(f"The run's {name} must be a finite number, but is {value}.")
        if duration <= 0.0:
            raise InputError(f"The run's duration must be above zero, but is {duration:g} s.")
        # NumPy's floats are slow, one by one
        omega, duration = None if omega is None else float(omega), float(duration)
        parameters = replace(self.parameters, A=float(self.amplitude))
        hooks = Hooks()
        self._runs += 1
        self.run_values = {}
        for each in self._hidden:
            # neither what else is hidden nor how far the last run was followed changes the chance
            rng = np.random.default_rng([self._seed, self._runs, crc32(each.effect.id.encode())])
            values = each.draw_run(rng)
            if each.effect.per_run:
                values = tuple((run_values or {}).get(each.effect.id, values))
                self.run_values[each.effect.id] = values
            each.install(hooks, parameters, values, omega, duration, rng)
        angle = drive(parameters.A, omega, hooks)
        self._angle = angle
        for late in hooks.late:
            late(angle)
        self._hooks, self._duration, self._arm = hooks, duration, angle
        first = 0.0 if release is None else float(release)
        self._motion = Motion(parameters, hooks, angle, first, duration)
        self._passed: deque[Segment] = deque()
        self._read_at = Instant()
        self._time = self._stamped = 0.0

    def true_time(self, recorded: float) -> float:
        """True time [s] at which the recorder takes the sample that it stamps `recorded` [s].

        The two differ where an effect of the clock is hidden. Call it once for a sample, in order.
        """
        t = float(recorded)
        for stamp in self._hooks.stamps:
            t = stamp(t)
        # samples keep their order, however the clock behaves
        self._stamped = max(t, self._stamped)
        return self._stamped

    def motion(self, t: float) -> tuple[float, float, float, float]:
        """phi1, phi2 [rad], v1, v2 [rad/s] of the bodies themselves at a true time [s].

        Args:
            t: not earlier than that of the last call.

        Raises:
            InputError: it is earlier, or not finite.
        """
        t = float(t)
        self._go_to(t)
        return self._at(t).read(t)

    def arm(self, t: float) -> float:
        """Angle of the motor's arm [rad] at a true time [s] of the run in progress.

        Not for rigs with play in their drive, whose arm has a memory of its own.
        """
        return self._arm(float(t))

    def advance(self, t: float) -> tuple[float, float]:
        """Goes on to a true time; what ideal sensors with the hidden effects report there [rad].

        Args:
            t: true time since the start of the run [s], not earlier than that of the last call.

        Raises:
            InputError: it is earlier, or not finite.
        """
        t = float(t)
        self._go_to(t)
        segment = self._at(t)
        phi1, phi2, v1, v2 = segment.read(t)
        hooks = self._hooks
        if not (hooks.sensor1 or hooks.sensor2 or hooks.delay):
            return phi1, phi2
        m = self._read_at
        m.t, m.s, m.v1, m.v2 = t, t / self._duration - 0.5, v1, v2
        m.phi1, m.phi2 = phi1, phi2
        m.z = segment.read_states(t)
        y1, y2 = phi1, phi2
        if hooks.delay:
            earlier = max(t - hooks.delay, 0.0)
            y2 = self._at(earlier).read(earlier)[1]
        for change in hooks.sensor1:
            y1 = change(y1, m)
        for change in hooks.sensor2:
            y2 = change(y2, m)
        return y1, y2

    def read_drive(self, t: float) -> float:
        """Angle of the spring's far end [rad] as it is recorded at a true time [s].

        Before the run the motor stands at neutral.

        Raises:
            InputError: play or steps of the motor are hidden, of which only the present is known.
        """
        if self._hooks.limits:
            raise InputError(
                "A drive with play or steps cannot be recorded; leave out drive_backlash and "
                "drive_steps, or the measured drive."
            )
        then = float(t) - self._hooks.drive_delay
        return self._angle(then) if then > 0.0 else 0.0

    def run(
        self,
        ts: ArrayLike,
        *,
        omega: float | None = None,
        release: float | None = None,
        duration: float | None = None,
        run_values: Mapping[str, Sequence[float]] | None = None,
    ) -> np.ndarray:
        """A whole run: readings (n, 2) [rad], without noise.

        Args:
            ts: (n,) times on the recorder's clock [s], increasing from 0 or later.
            omega, release, run_values: as in `start`.
            duration: as in `start`; the last of `ts` if None.

        Raises:
            InputError: as `start` and `advance`.
        """
        times = np.asarray(ts, dtype=float)
        if times.ndim != 1 or times.size == 0:
            raise InputError(f"The times must be in one row, but have the shape {times.shape}.")
        whole = float(times[-1]) if duration is None else duration
        self.start(
            omega=omega,
            release=release,
            run_values=run_values,
            duration=DURATION if whole <= 0.0 else whole,
        )
        self.taken = [self.true_time(t) for t in times.tolist()]
        return np.array([self.advance(t) for t in self.taken])

    @property
    def switches(self) -> int:
        """Number of times that a body of the run in progress began or ceased to slide."""
        return self._motion.switches

    @property
    def steps(self) -> int:
        """Number of steps of integration that the run in progress has taken."""
        return self._motion.steps

    def _go_to(self, t: float) -> None:
        if not np.isfinite(t):
            raise InputError(f"The time must be a finite number, but is {t}.")
        if t < self._time:
            raise InputError(f"The run is at {self._time:g} s already and cannot go back to {t:g}.")
        self._time = t
        ahead = t - min(self._hooks.delay, 0.0)
        if not self._passed:
            self._passed.append(self._motion.step())
        while self._motion.t < ahead:
            self._passed.append(self._motion.step())
        behind = t - max(self._hooks.delay, 0.0)
        while len(self._passed) > 1 and self._passed[1].t <= behind:
            self._passed.popleft()

    def _at(self, t: float) -> Segment:
        """The last segment that begins at or before `t`."""
        for segment in reversed(self._passed):
            if segment.t <= t:
                return segment
        return self._passed[0]
