"""The firmware of a virtual rig: it answers commands and samples bridges, as a real one does.

Bytes in, bytes out, by its own clock: `tp_jax.rig.serve` puts it behind a pseudo-terminal. The
clock may run fast or slow; as on a microcontroller, sampling and drive both hang on it.
"""

import math
import os
from typing import Any, Protocol, runtime_checkable

import numpy as np

from tp_jax.acquisition import protocol
from tp_jax.acquisition.parser import FrameParser
from tp_jax.acquisition.protocol import Ack, Announced, Command, Identity
from tp_jax.errors import InputError

REFERENCE = 3.3  # V, of the converter

# What this rig's bridges and amplifiers are: neither of two alike, nor in the middle.
SENSORS: dict[int, tuple[float, float, float, float, float]] = {
    1: (1.652, 2.61, 1.638, 2.58, 0.012),
    2: (1.641, 2.55, 1.663, 2.6, -0.021),
}
"""Sensor -> offset, gain, cosine offset, cosine gain, zero; see `recordings.calibration`."""

ERRORS = (5e-4, 1.5e-3, 5e-4, 1.5e-3, 3e-4)
"""Standard errors that are announced with them."""


@runtime_checkable
class Rig(Protocol):
    """Simulator as the emulator needs it; `tp_jax.rig.simulator.VirtualRig` is one."""

    amplitude: float

    def start(self, *, omega: float | None = None, release: float | None = None) -> None:
        """Begins a run at t = 0."""

    def advance(self, t: float) -> tuple[float, float]:
        """Angles [rad] at a true time [s], which does not decrease."""
        ...


class Bridges:
    """Two sensors of two bridges each, their amplifiers and the converter."""

    def __init__(self, noise: float, seed: int) -> None:
        """
        Args:
            noise: standard deviation, as an angle [rad].
            seed: of the noise.
        """
        self._rng = np.random.default_rng(seed)
        self._gains = np.array([s[i] for s in SENSORS.values() for i in (1, 3)])[
            ::-1
        ]  # popped from behind
        self._noise = noise
        self._drawn: list[list[float]] = []

    def noise(self) -> list[float]:
        """Noise of the four bridges [V], the first of them last."""
        if not self._drawn:
            draws = self._noise * self._gains * self._rng.standard_normal((4096, 4))
            self._drawn = draws[::-1].tolist()
        return self._drawn.pop()

    def read(self, phi1: float, phi2: float) -> tuple[int, int, int, int]:
        """Counts of sine 1, cosine 1, sine 2, cosine 2 at the angles [rad]."""
        noise = self.noise()
        counts = []
        for angle, each in ((phi1, SENSORS[1]), (phi2, SENSORS[2])):
            offset, gain, cosine_offset, cosine_gain, zero = each
            twice = 2.0 * (angle + zero)
            for volts in (
                offset + 0.5 * gain * math.sin(twice) + noise.pop(),
                cosine_offset + 0.5 * cosine_gain * math.cos(twice) + noise.pop(),
            ):
                counts.append(min(max(round(volts * protocol.FULL_SCALE / REFERENCE), 0), 65535))
        return counts[0], counts[1], counts[2], counts[3]


class Firmware:
    """The program of the virtual rig.

    Attributes:
        rate: samples per second of its own clock [Hz].
        skew: by which its clock is fast.
        sent: samples since the begin of the run.
        running: whether a run is on.
    """

    def __init__(
        self,
        rig: Rig,
        *,
        rate: float = 1000.0,
        noise: float = 1e-3,
        skew: float = 0.0,
        seed: int = 0,
        text: bool = False,
        omega: float | None = None,
        release: float | None = None,
        run_duration: float | None = None,
        name: str = "tp-jax virtual rig",
    ) -> None:
        """
        Args:
            rig: what is sampled.
            rate: [Hz].
            noise: of the sensors [rad].
            skew: of the clock, 1e-6 is a part per million.
            seed: of the noise.
            text: whether to send `t phi1 phi2` instead of frames. It then answers no command, and
                begins a run when first spoken to after the port was opened: a board that restarts.
            omega: of that run's drive [rad/s].
            release: or the angle [rad] at which the column is let go.
            run_duration: of a run [s], for effects that drift over it; None: the simulator's own.
            name: that it gives.
        """
        self.rig, self.rate, self.skew = rig, rate, skew
        self.running = False
        self.sent = 0
        self._bridges = Bridges(noise, seed)
        self._text = text
        self._own = (omega, release)
        self._start_options = {} if run_duration is None else {"duration": run_duration}
        self._name = name
        self._run = 0
        self._boot = int.from_bytes(os.urandom(4), "little")
        self._begin = 0  # [µs] of the own clock
        self._omega = 0.0
        self._answered: tuple[int, int, Ack] | None = None
        self._parser = FrameParser()

    # The host speaks ------------------------------------------------------------------------

    def hear(self, data: bytes, now: int) -> bytes:
        """Takes what the host sent, at a time of the own clock [µs]; returns the answers."""
        if self._text:
            if not self.running:
                self._start(now, *self._own)
            return b""
        answers = b""
        for message in self._parser.feed(data).messages:
            if isinstance(message, Command):
                answers += self._obey(message, now)
        return answers

    def plugged(self) -> None:
        """The host's end was opened anew."""
        self._parser.clear()

    def _obey(self, command: Command, now: int) -> bytes:
        if self._answered is not None and self._answered[:2] == (command.command, command.tag):
            return protocol.message(self._answered[2])
        if command.command == protocol.IDENTIFY:
            return self._introduce(command.tag)
        status, value, at = protocol.OK, 0, now
        try:
            if command.command == protocol.DRIVE:
                self._omega = command.values[0] / 1e6
                if command.values[1]:
                    self.rig.amplitude = command.values[1] / 1e6
                value = min(command.values[0], 2**31 - 1)
            elif command.command == protocol.START:
                at = self._start(now, self._omega or None, None)
            elif command.command == protocol.RELEASE:
                at = self._start(now, None, command.values[0] / 1e6)
                value = command.values[0]
            elif command.command == protocol.STOP:
                self.running = False
            else:
                status = protocol.UNKNOWN_COMMAND
        except InputError:
            self.running = False
            status = protocol.BAD_VALUE
        ack = Ack(command.tag, command.command, status, self._run, at % 2**32, value)
        self._answered = (command.command, command.tag, ack)
        return protocol.message(ack)

    def _introduce(self, tag: int) -> bytes:
        running = protocol.RUNNING if self.running else 0
        identity = Identity(
            name=self._name,
            wired=protocol.SINE1 | protocol.COSINE1 | protocol.SINE2 | protocol.COSINE2,
            flags=protocol.DRIVES | protocol.CALIBRATED | running,
            run=self._run,
            boot=self._boot,
            rate=self.rate,
            reference=REFERENCE,
            amplitude=self.rig.amplitude,
            tag=tag,
        )
        law = protocol.LAWS.index("sine_cosine")
        told = [Announced(sensor, law, v, ERRORS, tag) for sensor, v in SENSORS.items()]
        return b"".join(protocol.message(each) for each in (identity, *told))

    def _start(self, now: int, omega: float | None, release: float | None) -> int:
        # the drive counts the own clock's seconds
        driven = None if omega is None else omega * (1.0 + self.skew)
        options: dict[str, Any] = self._start_options
        self.rig.start(omega=driven, release=release, **options)
        self._run = (self._run + 1) % 256
        self._begin, self.sent, self.running = now, 0, True
        return now

    # The rig samples ------------------------------------------------------------------------

    @property
    def due(self) -> int | None:
        """Time at which the next sample is due on the own clock [µs]; None: no run is on."""
        return self._begin + round(self.sent * 1e6 / self.rate) if self.running else None

    def sample(self) -> bytes:
        """Takes the sample that is due; its bytes for the line."""
        due = self.due
        assert due is not None
        own = (due - self._begin) / 1e6
        true = own / (1.0 + self.skew)
        stamp = getattr(self.rig, "true_time", None)  # where a hidden effect moves the samples
        phi1, phi2 = self.rig.advance(true if stamp is None else stamp(true))
        sequence, self.sent = self.sent, self.sent + 1
        if self._text:
            _, n2, _, n1 = self._bridges.noise()
            phi1, phi2 = phi1 + n1 / SENSORS[1][1], phi2 + n2 / SENSORS[2][1]
            return f"{own:.6f} {phi1:.6f} {phi2:.6f}\r\n".encode()
        return protocol.sample(self._run, sequence, due, self._bridges.read(phi1, phi2))
