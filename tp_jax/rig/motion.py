"""Motion of the two bodies through sliding and rest: which of them slides which way, and when.

Within a mode (side1, side2), each +1, -1 or 0 for rest, the motion is smooth and is followed with
adaptive steps. A step that ends a sliding (its velocity would change sign), a rest (its friction
would exceed its limit) or crosses an event of an effect is taken again up to just there. A body at
zero velocity then rests or slides by whichever mode is consistent: at rest, friction within its
limits; sliding, acceleration to the side of sliding. With limits that are the same at rest and at
the onset of sliding exactly one is, for both bodies at once (a linear complementarity problem with
a P-matrix).
"""

from collections.abc import Callable
from functools import partial

from tp_jax.rig.equations import equations
from tp_jax.rig.hooks import Hooks, Instant
from tp_jax.rig.parameters import RigParameters
from tp_jax.rig.search import SHORTEST, STILL, TRIES, locate, lowest, stops
from tp_jax.rig.segment import Segment
from tp_jax.rig.stepper import End, stepper

SLACK = 1e-13  # of the torques at hand: how far beyond its limit friction counts as within
PASSED = 1e-12  # of an effect's event: so near its zero, the side is the one that was noted


class Motion:
    """A run in progress.

    Attributes:
        t: time [s] up to which the motion is known.
        phi1, phi2, v1, v2: there, [rad] and [rad/s].
        z: states of the effects.
        side1, side2: sense of sliding, 0 at rest.
        switches: changes of mode so far; steps: taken so far.
    """

    def __init__(
        self,
        parameters: RigParameters,
        hooks: Hooks,
        angle: Callable[[float], float],
        phi1: float = 0.0,
        duration: float = 10.0,
        v1: float = 0.0,
        v2: float = 0.0,
    ):
        """A run from `phi1` [rad], velocities `v1` and `v2` [rad/s]; others as in `equations`."""
        self.t = 0.0
        self.phi1, self.phi2, self.v1, self.v2 = phi1, 0.0, v1, v2
        self.z = list(hooks.start)
        self.side1 = self.side2 = 0
        self.switches = self.steps = 0
        self.now = Instant()
        self._hooks, self._rider = hooks, parameters.has_rider
        self._rates, self._limit1, self._limit2 = equations(
            parameters, hooks, self.now, angle, duration
        )
        self._take = stepper(self._rates, self._state_rates)
        self._length = 1e-3
        self._torque = parameters.k * 0.1 + parameters.M1 + parameters.Ts1  # scale, for rounding
        self._inertia = parameters.B1
        self._accelerate()
        self._choose(None, None)
        self._signs = [0] * len(hooks.events)

    def step(self) -> Segment:
        """Goes on by one step; what was passed."""
        hooks = self._hooks
        h = min(self._length, hooks.longest)
        if hooks.on_motion:
            self._accelerate()
            for commit in hooks.commits:
                commit(self.now, self._rider and self.side2 == 0)
            for limit in hooks.limits:
                h = min(h, limit(self.t, h))
            # a torque may have jumped, or its law have changed
            self._accelerate()
            if not (self.side1 and self.side2):
                self._release()
            for i, event in enumerate(hooks.events):
                value = event(self.now)
                if abs(value) > PASSED or not self._signs[i]:
                    self._signs[i] = _sign(value)
        for _ in range(TRIES):
            end, length = self._tolerable(h)
            switch = self._first_switch(end)
            if switch is None:
                self._length = length
                return self._accept(end)
            found, act = switch
            if found.h > SHORTEST:
                segment = self._accept(found)
                act()
                return segment
            act()
        # modes that contradict each other to rounding: whichever is left, for one short step
        return self._accept(self._trial(min(h, 1e-6)))

    # one step

    def _accelerate(self) -> None:
        """Accelerations and dry torques in the present state and mode."""
        self._a1, self._a2, self._F1, self._D2 = self._rates(
            self.t, self.phi1, self.phi2, self.v1, self.v2, self.z, self.side1, self.side2
        )
        self._dz = self._state_rates() if self.z else []

    def _state_rates(self) -> list[float]:
        return [x for rates in self._hooks.rates for x in rates(self.now)]

    def _trial(self, h: float) -> End:
        return self._take(
            h,
            self.t,
            self.phi1,
            self.phi2,
            self.v1,
            self.v2,
            self.z,
            self._a1,
            self._a2,
            self._dz,
            self.side1,
            self.side2,
        )

    def _tolerable(self, h: float) -> tuple[End, float]:
        """A step of `h` or less that is accurate enough, and the length to try next."""
        while True:
            end = self._trial(h)
            factor = 0.9 * end.error**-0.2 if end.error > 1e-5 else 9.0
            if end.error <= 1.0 or h < SHORTEST:
                # what cut this step short is no reason for short ones to come
                return end, min(max(h * min(factor, 5.0), min(self._length, h * factor)), 1.0)
            h *= max(factor, 0.1)

    def _accept(self, end: End) -> Segment:
        angles = (
            (self.phi1, self.v1, self._a1, end.phi1, end.v1, end.a1),
            (self.phi2, self.v2, self._a2, end.phi2, end.v2, end.a2),
        )
        states = [
            (*old, *new)
            for old, new in zip(
                zip(self.z, self._dz, strict=True), zip(end.z, end.dz, strict=True), strict=True
            )
        ]
        segment = Segment(self.t, end.h, angles, states)
        self.t += end.h
        self.phi1, self.phi2, self.v1, self.v2 = end.phi1, end.phi2, end.v1, end.v2
        self.z = end.z
        self._a1, self._a2, self._F1, self._D2, self._dz = end.a1, end.a2, end.F1, end.D2, end.dz
        self.steps += 1
        return segment

    # what ends a step

    def _first_switch(self, end: End) -> tuple[End, Callable[[], None]] | None:
        """The earliest event of a step: the step that ends there, and what is to be done there."""
        # what is to be done, a gap that falls to zero there, a step by which it has
        checks: list[tuple[Callable[[], None], Callable[[End], float], End]] = []
        one, two = self.side1, self.side2
        if one:
            ends = self.v1, self._a1, end.v1, end.a1
            if stops(end.h, one, *ends):
                by = end if one * end.v1 < 0.0 else self._dip(one, *ends, end)
                checks.append((self._stop1, lambda e: one * e.v1, by))
        elif self._excess1(end.F1) > 0.0:
            checks.append((self._leave1, lambda e: -self._excess1(e.F1), end))
        if self._rider and two:
            ends = self.v2, self._a2, end.v2, end.a2
            if stops(end.h, two, *ends):
                by = end if two * end.v2 < 0.0 else self._dip(two, *ends, end)
                checks.append((self._stop2, lambda e: two * e.v2, by))
        elif self._rider:
            self._at(end)
            if self._excess2(end.D2) > 0.0:
                checks.append((self._leave2, lambda e: -self._excess2(e.D2), end))
        if self._hooks.events:
            self._at(end)
            for i, event in enumerate(self._hooks.events):
                if self._signs[i] * event(self.now) < 0.0:
                    checks.append((partial(self._pass, i), partial(self._beyond, i), end))
        found: tuple[End, Callable[[], None]] | None = None
        for act, gap, by in checks:
            limit = by if found is None or by.h <= found[0].h else found[0]
            there = locate(lambda e, gap=gap: gap(self._at(e)), self._trial, self._start(), limit)
            if there is not None and (found is None or there.h < found[0].h):
                found = there, act
        return found

    def _at(self, end: End) -> End:
        """The same end, with the instant that effects look at set to it."""
        if self._hooks.on_motion:
            self._rates(
                self.t + end.h, end.phi1, end.phi2, end.v1, end.v2, end.z, self.side1, self.side2
            )
        return end

    def _start(self) -> End:
        return End(
            0.0,
            self.phi1,
            self.phi2,
            self.v1,
            self.v2,
            self.z,
            self._a1,
            self._a2,
            self._F1,
            self._D2,
            self._dz,
            0.0,
        )

    def _dip(self, side: int, v: float, a: float, v_end: float, a_end: float, end: End) -> End:
        """The step to the lowest velocity of a body, where that lies within a step."""
        return self._trial(lowest(end.h, side * v, side * a, side * v_end, side * a_end))

    # friction at rest

    def _excess1(self, F1: float) -> float:
        """Excess of the friction needed for rest over its limit, in the instant of effects."""
        side = 1.0 if F1 >= 0.0 else -1.0
        return side * F1 - self._limit1(side, 0.0, True) - SLACK * self._torque

    def _excess2(self, D2: float) -> float:
        side = 1.0 if D2 >= 0.0 else -1.0
        return side * D2 - self._limit2(side, 0.0, True) - SLACK * self._torque

    def _release(self) -> None:
        """Lets go a body whose friction at rest does not hold it any longer."""
        if self.side1 == 0 and self._excess1(self._F1) > 0.0:
            self._leave1()
        if self._rider and self.side2 == 0 and self._excess2(self._D2) > 0.0:
            self._leave2()

    # switching

    def _stop1(self) -> None:
        self.v1 = 0.0
        self._choose(None, None)

    def _stop2(self) -> None:
        self.v2 = 0.0
        self._choose(None, None)

    def _leave1(self) -> None:
        self._accelerate()
        self._choose(1 if self._F1 >= 0.0 else -1, None)

    def _leave2(self) -> None:
        # friction on the rider is -M_T: it slides against the torque that holds it
        self._accelerate()
        self._choose(None, 1 if self._D2 >= 0.0 else -1)

    def _pass(self, i: int) -> None:
        self._signs[i] = -self._signs[i]

    def _beyond(self, i: int, end: End) -> float:  # noqa: ARG002
        """Distance to an event of an effect, in the instant of effects; below zero beyond."""
        return self._signs[i] * self._hooks.events[i](self.now)

    def _choose(self, forced1: int | None, forced2: int | None) -> None:
        """The mode that is consistent now; a forced side is that of a body that just let go."""
        if abs(self.v1) <= STILL and self.side1 * self._a1 <= 0.0:
            self.v1 = 0.0
        if abs(self.v2) <= STILL and self.side2 * self._a2 <= 0.0:
            self.v2 = 0.0
        first = self._candidates(self.v1, forced1)
        second = self._candidates(self.v2, forced2) if self._rider else (0,)
        best, mode = float("inf"), (0, 0)
        old = self.side1, self.side2
        for one in first:
            for two in second:
                self.side1, self.side2 = one, two
                self._accelerate()
                wrong = self._contradiction()
                if wrong < best:
                    best, mode = wrong, (one, two)
                if wrong == 0.0:
                    break
            if best == 0.0:
                break
        self.side1, self.side2 = mode
        self.switches += mode != old
        self._accelerate()

    def _candidates(self, v: float, forced: int | None) -> tuple[int, ...]:
        if v != 0.0:
            return (1 if v > 0.0 else -1,)
        return (0, 1, -1) if forced is None else (forced,)

    def _contradiction(self) -> float:
        """Measures how far the present mode contradicts itself [N m]; 0 for a consistent one."""
        wrong = 0.0
        B = self._torque
        if self.side1 == 0:
            wrong += max(self._excess1(self._F1), 0.0)
        elif self.v1 == 0.0:
            wrong += max(-self.side1 * self._a1 * self._inertia - SLACK * B, 0.0)
        if not self._rider:
            return wrong
        if self.side2 == 0:
            wrong += max(self._excess2(self._D2), 0.0)
        elif self.v2 == 0.0:
            wrong += max(-self.side2 * self._a2 * self._inertia - SLACK * B, 0.0)
        return wrong


def _sign(x: float) -> int:
    return (x > 0.0) - (x < 0.0)
