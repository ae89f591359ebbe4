"""The emulated firmware, its line and its pseudo-terminal."""

import os

import numpy as np
import pytest

from tests.acquisition.swing import Swing, emulated, port_of
from tests.waiting import until
from tp_jax.acquisition import Settings, protocol, record
from tp_jax.acquisition.parser import FrameParser
from tp_jax.acquisition.protocol import Ack, Announced, Command, Identity
from tp_jax.rig.emulator import Bridges, Firmware
from tp_jax.rig.serve import BUFFER, Line, Terminal


def asked(firmware, *commands, now=0):
    """What the firmware answers to commands."""
    answers = [firmware.hear(protocol.message(each), now) for each in commands]
    return [m for each in answers for m in FrameParser().feed(each).messages]


def test_it_says_who_it_is():
    firmware = Firmware(Swing(), rate=500.0)
    identity, first, second = asked(firmware, Command(protocol.IDENTIFY, 7))
    assert isinstance(identity, Identity)
    assert (identity.rate, identity.tag, identity.amplitude) == (500.0, 7, 0.18)
    assert identity.drives
    assert not identity.running
    assert [each.sensor for each in (first, second) if isinstance(each, Announced)] == [1, 2]


def test_a_command_said_twice_is_obeyed_once():
    firmware = Firmware(Swing())
    start = Command(protocol.START, 9)
    first, again = asked(firmware, start, start, now=500)
    assert first == again == Ack(9, protocol.START, protocol.OK, run=1, time=500)
    (other,) = asked(firmware, Command(protocol.START, 10), now=700)
    assert (other.run, other.time) == (2, 700)
    assert len(firmware.rig.started) == 2


def test_commands_reach_the_rig():
    firmware = Firmware(Swing(), skew=1e-3)
    drive = Command(protocol.DRIVE, 1, (13_090_000, 250_000))
    (ack,) = asked(firmware, drive)
    assert ack.value == 13_090_000
    assert firmware.rig.amplitude == 0.25
    asked(firmware, Command(protocol.START, 2))
    assert firmware.running
    asked(firmware, Command(protocol.STOP, 3))
    assert not firmware.running
    assert firmware.due is None
    asked(firmware, Command(protocol.RELEASE, 4, (-300_000,)))
    # by the rig's own clock, which is fast
    assert firmware.rig.started == [(pytest.approx(13.09 * 1.001), None), (None, -0.3)]


def test_samples_are_timed_by_its_own_clock():
    firmware = Firmware(Swing(), rate=300.0, noise=0.0)
    asked(firmware, Command(protocol.START, 1), now=2**32 - 5000)
    parser = FrameParser()
    frames = parser.feed(b"".join(firmware.sample() for _ in range(10))).samples
    np.testing.assert_array_equal(frames["sequence"], np.arange(10))
    expected = (2**32 - 5000 + np.rint(np.arange(10) * 1e6 / 300)) % 2**32
    np.testing.assert_array_equal(frames["time"], expected)


def test_the_noise_is_what_was_asked_for():
    bridges = Bridges(noise=2e-3, seed=3)
    from tp_jax.recordings.calibration import SensorCalibration
    from tp_jax.rig.emulator import REFERENCE, SENSORS

    counts = np.array([bridges.read(0.3, -1.0) for _ in range(20000)]) * REFERENCE / 65535
    for first, angle, values in ((0, 0.3, SENSORS[1]), (2, -1.0, SENSORS[2])):
        sensor = SensorCalibration("sine_cosine", np.array(values), np.zeros((5, 5)))
        read = sensor.angle(counts[:, first : first + 2])
        assert read.mean() == pytest.approx(angle, abs=1e-4)
        assert read.std() == pytest.approx(2e-3, rel=0.03)


def test_a_line_as_bad_as_it_should_be():
    data = bytes(100_000)
    assert Line().carry(data) is data
    got = np.frombuffer(Line(corrupt=0.02, seed=1).carry(data), dtype=np.uint8)
    assert got.size == 100_000
    assert np.mean(got != 0) == pytest.approx(0.02, rel=0.1)
    assert len(Line(drop=0.03, seed=1).carry(data)) == pytest.approx(97_000, rel=0.003)
    assert Line(0.02, 0.03, 5).carry(data) == Line(0.02, 0.03, 5).carry(data)


def test_the_port_keeps_its_name():
    terminal = Terminal()
    try:
        assert terminal.path.is_symlink()
        terminal.plug()  # nothing to do
        terminal.unplug()
        terminal.unplug()
        assert not os.path.lexists(terminal.path)
        terminal.plug()
        with open(terminal.path, "rb", buffering=0) as end:
            os.write(terminal.master, b"hello\n\0\x11")
            assert end.read(8) == b"hello\n\0\x11"  # raw: nothing is taken for a control character
    finally:
        terminal.close()
    assert not terminal.path.parent.exists()


def test_a_host_that_does_not_read_stops_nothing():
    with emulated(speed=20.0) as rig:
        rig.firmware._start(rig._now(), 5.0, None)
        until(lambda: rig.firmware.sent > 4000 and rig.overflowed > 0)
        assert len(rig._queue) <= BUFFER


def test_unplugging_on_request(tmp_path):
    with emulated(speed=2.0) as rig:
        assert os.path.exists(rig.port)
        rig.unplug()
        until(lambda: not os.path.lexists(rig.port))
        rig.plug()
        until(lambda: os.path.exists(rig.port))
        record(port_of(rig), tmp_path / "run.csv", Settings(0.3, omega=3.0))
