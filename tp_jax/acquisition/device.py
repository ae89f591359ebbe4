"""The rig at the other end of the port: who it is, and what it is told."""

import itertools
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from tp_jax.acquisition import protocol
from tp_jax.acquisition.frames import END
from tp_jax.acquisition.parser import Batch, FrameParser
from tp_jax.acquisition.port import Port
from tp_jax.acquisition.protocol import Ack, Announced, Command, Identity, Message
from tp_jax.acquisition.text_stream import TextParser
from tp_jax.errors import InputError

ANSWER_WITHIN = 0.4
"""Seconds until a command is sent again: the answer, or the command, may have been damaged."""

TEXT_LINES = 3
"""Lines of numbers after which a stream is text."""


class Device:
    """Speaks with the rig.

    Attributes:
        port: the port.
        frames: the parser of its frames.
        text: the parser of its lines.
        identity: who answered; None before `identify`, and where the stream is text.
        announced: the calibrations it announced.
        samples: (batch, arrival) of the samples that came while an answer was waited for.
        rows: (rows, arrival) of text, likewise.
    """

    def __init__(self, port: Port) -> None:
        self.port = port
        self.frames = FrameParser()
        self.text = TextParser()
        self.identity: Identity | None = None
        self.announced: dict[int, Announced] = {}
        self.samples: list[tuple[Batch, float]] = []
        self.rows: list[tuple[np.ndarray, float]] = []
        self._messages: tuple[Message, ...] = ()  # of the last bytes
        # from a number that differs from run to run: the rig takes a command with the tag of the
        # last one for a repetition of it
        self._tags = itertools.cycle(range(1, 256))
        for _ in range(time.monotonic_ns() // 1_000_003 % 255):
            next(self._tags)

    @property
    def is_text(self) -> bool:
        """Whether the stream is lines of numbers."""
        return self.identity is None and self.text.good >= TEXT_LINES

    def identify(self, patience: float) -> None:
        """Finds out who is there: a rig that answers, or a stream of text.

        Args:
            patience: seconds; a board that restarts when its port is opened needs some two.

        Raises:
            InputError: nothing came, or nothing that could be understood.
            Unplugged: the port has gone.
        """
        before = self.port.received
        self.identity = None
        tag = next(self._tags)

        def answered() -> bool:
            return self.is_text or (self.identity is not None and self.identity.tag == tag)

        if not self._ask(Command(protocol.IDENTIFY, tag), answered, patience):
            name, baud, came = self.port.name, self.port.baud, self.port.received - before
            if not came:
                raise InputError(
                    f"Nothing came from {name} in {patience:g} s; check the cable, the rig's power "
                    "and that its firmware runs."
                )
            raise InputError(
                f"What came from {name} at {baud} baud, {came} bytes, is neither frames nor "
                "lines of numbers; give the rig's own --baud."
            )
        if self.identity is not None and not (self.identity.rate and self.identity.reference):
            raise InputError(
                f"The rig at {self.port.name} announces a sample rate or a reference of 0; set "
                "both in its firmware."
            )
        if self.identity is not None and self.identity.protocol != protocol.VERSION:
            raise InputError(
                f"The rig at {self.port.name} speaks version {self.identity.protocol} of the "
                f"protocol, but this program speaks {protocol.VERSION}; update the older one."
            )

    def calibrations(self, patience: float) -> dict[int, Announced]:
        """What the rig announces for its sensors, asked again where the line lost a part of it."""
        identity = self.identity
        if identity is None or not identity.calibrated:
            return {}
        sensors = {1: protocol.SINE1, 2: protocol.SINE2}
        wired = {sensor for sensor, bit in sensors.items() if identity.wired & bit}
        if not wired <= set(self.announced):
            command = Command(protocol.IDENTIFY, next(self._tags))
            self._ask(command, lambda: wired <= set(self.announced), patience)
        return self.announced

    def command(self, kind: int, *values: float, patience: float = 5.0) -> Ack:
        """Has a command carried out.

        Args:
            kind: of the protocol's commands.
            *values: in SI units.
            patience: seconds.

        Raises:
            InputError: the rig refuses, or does not answer.
            Unplugged: the port has gone.
        """
        name = protocol.COMMANDS[kind]
        content = Command(kind, next(self._tags), tuple(protocol.micro(v) for v in values))
        try:
            protocol.message(content)
        except ValueError:
            largest = max(values, key=abs)
            raise InputError(
                f"The rig cannot be told to {name} at {largest:g}; give a smaller number."
            ) from None
        found: list[Ack] = []

        def answered() -> bool:
            found.extend(m for m in self._messages if isinstance(m, Ack) and m.tag == content.tag)
            return bool(found)

        if not self._ask(content, answered, patience):
            raise InputError(
                f"The rig at {self.port.name} does not answer the command {name}; restart it."
            )
        if found[0].status != protocol.OK:
            what = protocol.STATUS.get(found[0].status, "refuses")
            raise InputError(
                f"The rig at {self.port.name} {what}: {name} "
                f"{' '.join(f'{v:g}' for v in values)}".rstrip()
                + "; ask for what it can do."
            )
        return found[0]

    def stop(self) -> None:
        """Tells the rig to stop; what it says to that is not waited for long."""
        if self.identity is None:
            return
        tag = next(self._tags)
        self._ask(
            Command(protocol.STOP, tag),
            lambda: any(isinstance(m, Ack) and m.tag == tag for m in self._messages),
            1.0,
        )

    def forget(self) -> None:
        """Forgets what came so far, and what had begun to: the line was interrupted."""
        self.frames.clear()
        self.text.clear()
        self.samples.clear()
        self.rows.clear()

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
        """Reads once; keeps what the recording may want."""
        data, arrival = self.port.read(0.05)
        self._messages = ()
        if not data:
            return
        batch = self.frames.feed(data)
        self._messages = batch.messages
        for message in batch.messages:
            if isinstance(message, Identity):
                self.identity = replace(message, name=message.name.strip("\0 \r\n"))
            elif isinstance(message, Announced):
                self.announced[message.sensor] = message
        if batch.samples.size:
            self.samples.append((batch, arrival))
        if self.identity is None and not self.frames.good:
            rows = self.text.feed(data)
            if len(rows):
                self.rows.append((rows, arrival))
