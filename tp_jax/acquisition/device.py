"""The rig at the other end of the port: who it is, and what it is told."""

import itertools
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from tp_jax.acquisition import protocol
from tp_jax.acquisition.frames import END
from tp_jax.acquisition.parser import FrameParser, TextParser
from tp_jax.acquisition.port import Port
from tp_jax.acquisition.protocol import Ack, Announced, Command, Identity, Message
from tp_jax.errors import InputError
from tp_jax.recordings.calibration import Calibration, SensorCalibration, nominal

# Seconds until a command is sent again, since the answer or the command may have been damaged, and
# until it is given up.
ANSWER_WITHIN, _OBEYED_WITHIN = 0.4, 5.0
TEXT_LINES = 3  # lines of numbers after which a stream is text
_SHOWN = 60  # characters of what came and could not be read
_BRIDGES = {"phi1": (protocol.SINE1, protocol.COSINE1), "phi2": (protocol.SINE2, protocol.COSINE2)}


class Device:
    """Speaks with the rig."""

    def __init__(self, port: Port) -> None:
        self.port = port
        self.identity: Identity | None = None  # None before `identify`, and where it is text
        self.text = TextParser()  # which tells that it is
        self.heard: list[tuple[bytes, float]] = []  # with arrival, while an answer was waited for
        self._frames = FrameParser()
        self._announced: dict[int, Announced] = {}
        self._messages: tuple[Message, ...] = ()  # of the last bytes
        # from a number that differs from run to run: the rig takes a command with the tag of the
        # last one for a repetition of it
        self._tags = itertools.cycle(range(1, 256))
        for _ in range(time.monotonic_ns() // 1_000_003 % 255):
            next(self._tags)

    def identify(self, patience: float) -> None:
        """Finds out who is there, a rig that answers or a stream of text, or raises InputError.

        A board that restarts when its port is opened needs some two seconds of patience. A rig that
        was known stays so where it does not answer again: it may still run, and has to be stopped.
        """
        known, self.identity = self.identity, None
        try:
            self._identify(patience)
        except BaseException:
            self.identity = known
            raise

    def _identify(self, patience: float) -> None:
        name, before = self.port.name, self.port.received
        tag = next(self._tags)

        def answered() -> bool:
            if self.identity is None:
                return self.text.good >= TEXT_LINES
            return self.identity.tag == tag

        if not self._ask(Command(protocol.IDENTIFY, tag), answered, patience):
            came = self.port.received - before
            if not came:
                raise InputError(
                    f"Nothing came from {name} in {patience:g} s; check the cable, the rig's power "
                    "and that its firmware runs."
                )
            raise InputError(
                f"What came from {name} at {self.port.baud} baud, {came} bytes, is neither frames "
                f"nor lines of numbers; {_shown(b''.join(data for data, _ in self.heard[-9:]))}"
            )
        if self.identity is not None and not (self.identity.rate and self.identity.reference):
            raise InputError(
                f"The rig at {name} announces a sample rate or a reference of 0; set both in its "
                "firmware."
            )
        if self.identity is not None and self.identity.protocol != protocol.VERSION:
            raise InputError(
                f"The rig at {name} speaks version {self.identity.protocol} of the protocol, but "
                f"this program speaks {protocol.VERSION}; update the older one."
            )

    def calibration(self, given: Calibration | None, patience: float) -> Calibration:
        """The calibration of the sensors: given, else announced, else nominal; of text: none."""
        identity = self.identity
        if identity is None:
            bits = protocol.SINE1 | (protocol.SINE2 if self.text.columns == 3 else 0)
        else:
            bits = identity.wired
        wired = {n: i for i, (n, (sine, _)) in enumerate(_BRIDGES.items(), 1) if bits & sine}
        if "phi1" not in wired:
            raise InputError("The rig has no sine bridge on the column wired; connect it.")
        if given is not None:
            for name in wired:
                self._check(given, name, bool(bits & _BRIDGES[name][1]))
            return Calibration({name: given.sensors[name] for name in wired}, given.source)
        if identity is None:
            return Calibration()  # its numbers are angles
        # the line may have lost a part of the announcements that came with the identity
        if identity.calibrated and not set(wired.values()) <= set(self._announced):
            command = Command(protocol.IDENTIFY, next(self._tags))
            self._ask(command, lambda: set(wired.values()) <= set(self._announced), patience)
        sensors, sources = {}, set()
        for name, number in wired.items():
            told = self._announced.get(number)
            if identity.calibrated and told is not None and told.law < len(protocol.LAWS):
                sensors[name] = _announced(told)
                sources.add("announced by the rig")
            else:
                sensors[name] = nominal(identity.reference, bool(bits & _BRIDGES[name][1]))
                sources.add("nominal, to be replaced by a calibration of this rig")
        return Calibration(sensors, "; ".join(sorted(sources)))

    def command(self, kind: int, *values: float) -> Ack:
        """Has a command carried out, values in SI units; InputError where the rig does not."""
        name = protocol.COMMANDS[kind]
        try:
            ack = self._acknowledged(kind, values, _OBEYED_WITHIN)
        except ValueError:
            largest = max(values, key=abs)
            raise InputError(
                f"The rig cannot be told to {name} at {largest:g}; give a smaller number."
            ) from None
        if ack is None:
            raise InputError(
                f"The rig at {self.port.name} does not answer the command {name}; restart it."
            )
        if ack.status != protocol.OK:
            known = ack.status < len(protocol.STATUS)
            what = protocol.STATUS[ack.status] if known else "refuses"
            asked = " ".join([name, *(f"{v:g}" for v in values)])
            raise InputError(
                f"The rig at {self.port.name} {what}: {asked}; ask for what it can do."
            )
        return ack

    def stop(self) -> bool:
        """Tells the rig to stop, and says whether it did, as far as one can tell.

        An answer is not waited for long. A stream of text is told nothing.
        """
        return self.identity is None or self._acknowledged(protocol.STOP, (), 1.0) is not None

    def forget(self) -> None:
        """Forgets all that came so far, and what had begun to: the line was interrupted."""
        self._frames.clear()
        self.text.clear()
        self.heard.clear()

    def _acknowledged(self, kind: int, values: tuple[float, ...], patience: float) -> Ack | None:
        content = Command(kind, next(self._tags), tuple(protocol.micro(v) for v in values))
        found: list[Ack] = []

        def answered() -> bool:
            found.extend(m for m in self._messages if isinstance(m, Ack) and m.tag == content.tag)
            return bool(found)

        return found[0] if self._ask(content, answered, patience) else None

    def _ask(self, content: Command, answered: Callable[[], bool], patience: float) -> bool:
        """Sends a command again and again until it is answered; says whether it was."""
        wire = END + protocol.message(content)  # the end clears the rig's line
        deadline = time.monotonic() + patience
        while (now := time.monotonic()) < deadline:
            self.port.write(wire)
            until = min(now + ANSWER_WITHIN, deadline)
            while time.monotonic() < until:
                self._take()
                if answered():
                    return True
        return False

    def _take(self) -> None:
        """Reads once; keeps the bytes, in which the recording may begin."""
        data, arrival = self.port.read(0.05)
        if data:
            self.heard.append((data, arrival))
        self._messages = self._frames.feed(data).messages
        for message in self._messages:
            if isinstance(message, Identity):
                self.identity = replace(message, name=message.name.strip("\0 \r\n"))
            elif isinstance(message, Announced):
                self._announced[message.sensor] = message
        if self.identity is None and not self._frames.good:
            self.text.feed(data)

    def _check(self, given: Calibration, name: str, cosine: bool) -> None:
        """Faults a calibration without this sensor, or for a bridge that is not there."""
        if name not in given.sensors:
            whose = "stream" if self.identity is None else "rig"
            raise InputError(
                f"The calibration {given.source} has no [{name}], which the {whose} has; add it."
            )
        if given.sensors[name].needs_cosine and not cosine:
            if self.identity is None:
                raise InputError(
                    f"The calibration of {name} needs the cosine bridge, but a text stream has one "
                    'column for a sensor; use the law "sine" or "line".'
                )
            raise InputError(
                f"The calibration {given.source} of {name} needs the cosine bridge, which the rig "
                'has not wired; use the law "sine" or wire it.'
            )


def _shown(data: bytes) -> str:
    """Shows a line of bytes that were not understood, and says what to do about them."""
    lines = [line for line in data.replace(b"\r", b"\n").split(b"\n") if line.strip()]
    line = max(lines[1:-1] or lines, key=len, default=b"")  # the outer ones may be parts of lines
    text = repr(line)[2 : _SHOWN + 2].removesuffix("'")
    if line.isascii() and line.decode().replace("\t", " ").isprintable():
        return f'a line of it is "{text}"; print lines of t phi1 phi2 alone, as 0.004 0.1 -0.2.'
    return f'a part of it is "{text}"; give the rig\'s own --baud.'


def _announced(told: Announced) -> SensorCalibration:
    law = protocol.LAWS[told.law]
    p = 5 if law == "sine_cosine" else 2
    # as the decimal numbers that single precision stands for: 1.7, not 1.7000000476837158
    values, errors = ([float(f"{x:.7g}") for x in part[:p]] for part in (told.values, told.errors))
    return SensorCalibration(law, np.array(values), np.diag(np.square(errors)))
