"""Rigs and helpers for the tests: known motions behind the emulated firmware."""

import math
import time
from contextlib import contextmanager

from tp_jax.acquisition import protocol
from tp_jax.acquisition.port import Port
from tp_jax.rig.emulator import Firmware
from tp_jax.rig.serve import Emulator, Line


class Swing:
    """A stand-in for the simulator: a swinging column, a ring that winds round and round."""

    def __init__(self):
        self.amplitude = 0.18
        self.started = []

    def start(self, *, omega=None, release=None):
        self.started.append((omega, release))
        self.omega = omega or 5.0

    def advance(self, t):
        return 0.6 * math.sin(self.omega * t), 2.0 * t + 0.3 * math.sin(3.0 * t)


class Ledger(Firmware):
    """A firmware that remembers what it sent.

    sent_samples: sequence -> (time [µs] since the begin, four readings) of the latest run.
    """

    def __init__(self, *arguments, **options):
        super().__init__(*arguments, **options)
        self.sent_samples = {}

    def _start(self, now, omega, release):
        self.sent_samples = {}
        return super()._start(now, omega, release)

    def sample(self):
        wire = super().sample()
        if wire.endswith(b"\0"):
            from tp_jax.acquisition.frames import decode

            frame = decode(wire[:-1])
            _, _, sequence, due, *readings = protocol._SAMPLE.unpack(frame[:-4])
            self.sent_samples[sequence] = ((due - self._begin) % 2**32, tuple(readings))
        return wire


@contextmanager
def emulated(*, speed=5.0, corrupt=0.0, drop=0.0, unplug=None, seed=0, **options):
    """An emulator with a `Ledger` that serves in a thread."""
    firmware = Ledger(Swing(), seed=seed, **options)
    line = Line(corrupt, drop, seed)
    with Emulator(firmware, speed=speed, line=line, unplug=unplug) as emulator:
        yield emulator


def port_of(emulator, baud=protocol.BAUD):
    """Its port, opened with pySerial, and the host's clock as fast as the emulator's."""
    speed = emulator.speed or 1.0
    return Port(emulator.port, baud, lambda: speed * time.monotonic())
