"""Recordings through a real pseudo-terminal: pySerial at one end, the emulated rig at the other."""

import errno
import json
import os
import signal
import sys
import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest

from tests.acquisition.swing import emulated, port_of
from tests.waiting import PATIENCE, running, until
from tp_jax.acquisition import Settings, fit_clock, protocol, record, writer
from tp_jax.acquisition.device import Device
from tp_jax.acquisition.recorder import MAY_STILL_RUN, correction
from tp_jax.acquisition.run_log import metadata_path
from tp_jax.errors import InputError
from tp_jax.recordings import load_campaign, read_columns
from tp_jax.recordings.calibration import Calibration, SensorCalibration
from tp_jax.rig.emulator import REFERENCE, SENSORS


def table(path):
    values = read_columns(path).values
    return np.column_stack([values[name] for name in ("t", "phi1", "phi2")])


def expected(firmware, sequence):
    """(n, 2) angles for the readings the firmware sent, ring not unwrapped."""
    readings = np.array([firmware.sent_samples[n][1] for n in sequence]) * REFERENCE / 65535
    angles = []
    for first, values in ((0, SENSORS[1]), (2, SENSORS[2])):
        sensor = SensorCalibration("sine_cosine", np.array(values), np.zeros((5, 5)))
        angles.append(sensor.angle(readings[:, first : first + 2]))
    return np.column_stack(angles)


def check_no_wrong_sample(rows, firmware, until=np.inf):
    """Every row is what the rig sent at that time; until then the ring's turns are right too."""
    sequence = np.rint(rows[:, 0] * firmware.rate).astype(int)
    np.testing.assert_array_equal(rows[:, 0], sequence / firmware.rate)
    sent = expected(firmware, sequence)
    np.testing.assert_allclose(rows[:, 1], sent[:, 0], atol=1e-12)
    turns = (rows[:, 2] - sent[:, 1]) / np.pi
    np.testing.assert_allclose(turns, np.rint(turns), atol=1e-12)
    # the ring of the stand-in winds: it was followed
    followed = rows[rows[:, 0] < until]
    ring = 2.0 * followed[:, 0] + 0.3 * np.sin(3.0 * followed[:, 0])
    np.testing.assert_allclose(followed[:, 2], ring, atol=0.01)


def test_nothing_is_lost(tmp_path):
    out = tmp_path / "run.csv"
    with emulated(speed=5.0) as rig:
        done = record(port_of(rig), out, Settings(10.0, omega=13.09, command=["me"]))
        started, firmware = rig.firmware.rig.started, rig.firmware
    assert started == [(13.09, None)]
    rows = table(out)
    assert rows.shape == (10001, 3)
    np.testing.assert_array_equal(rows[:, 0], np.arange(10001) / 1000)
    check_no_wrong_sample(rows, firmware)
    assert (done.state, done.rows, done.omega, done.forced) == ("complete", 10001, 13.09, True)
    assert done.fault is None
    meta = json.loads(metadata_path(out).read_text())
    assert meta == done.metadata
    assert meta["state"] == "complete"
    assert meta["samples"] == {
        "written": 10001,
        "lost": 0,
        "implausible": 0,
        "clipped": {"phi1": 0, "phi2": 0},
    }
    assert meta["frames"]["corrupt"] == 0
    assert meta["gaps"] == []
    assert meta["device"]["name"] == "tp-jax virtual rig"
    assert meta["baud"] == 460800
    assert meta["command"] == ["me"]
    assert meta["calibration"]["phi1"]["offset"] == SENSORS[1][0]
    assert 1e-4 < meta["calibration"]["phi1"]["standard_error"]["largest"] < 1e-3
    assert (
        abs(
            time.time()
            - time.mktime(time.strptime(meta["started"][:19], "%Y-%m-%dT%H:%M:%S"))
            + time.timezone
        )
        < 60
    )
    assert load_campaign(out, omega=13.09).recordings[0].n == 10001


@pytest.mark.parametrize(("corrupt", "drop"), [(0.01, 0.0), (0.0, 0.01), (0.005, 0.005)])
def test_a_bad_line(corrupt, drop, tmp_path):
    out = tmp_path / "run.csv"
    with emulated(speed=5.0, corrupt=corrupt, drop=drop) as rig:
        done = record(port_of(rig), out, Settings(6.0, omega=13.09, patience=20.0))
        firmware = rig.firmware
    rows = table(out)
    check_no_wrong_sample(rows, firmware)
    assert 0.74 * 6001 < len(rows) < 0.84 * 6001
    # every sample is in the file or counted as lost, and a gap is a jump of the time
    samples = done.metadata["samples"]
    assert samples["written"] + samples["lost"] == 6001
    assert samples["implausible"] == 0
    missing = np.rint(np.diff(rows[:, 0]) * 1000).astype(int) - 1
    ends = 6000 - round(rows[-1, 0] * 1000) + round(rows[0, 0] * 1000)
    assert missing.sum() + ends == samples["lost"]
    assert done.metadata["frames"]["corrupt"] > 0.7 * samples["lost"]


def test_unplugged_and_plugged_in_again(tmp_path):
    out, seen = tmp_path / "run.csv", []
    with emulated(speed=4.0, unplug=(3.0, 2.0)) as rig:
        done = record(port_of(rig), out, Settings(8.0, omega=13.09), progress=seen.append)
        firmware = rig.firmware
    assert done.state == "complete"
    rows = table(out)
    (gap,) = done.metadata["gaps"]
    # how often the ring went round meanwhile nobody can know, and that is said
    check_no_wrong_sample(rows, firmware, until=gap["before"])
    assert done.metadata["uncertain_turns"] == {"phi2": [gap["before"]]}
    assert gap["cause"] == "unplugged"
    assert 2.8 < gap["after"] <= 3.0
    assert 5.0 <= gap["before"] < 6.5
    jump = int(np.argmax(np.diff(rows[:, 0])))
    assert rows[jump, 0] == gap["after"]
    assert rows[jump + 1, 0] == gap["before"]
    assert done.metadata["samples"]["lost"] == gap["samples"] == 8001 - len(rows)
    assert rows[-1, 0] == 8.0
    assert any(status.unplugged for status in seen)
    assert seen[-1].written > 3000
    assert seen[-1].recent.shape[1] == 3


def test_a_rig_that_does_not_come_back(tmp_path):
    out = tmp_path / "run.csv"
    # in real time: what is on the line when it is unplugged is lost, and a busy host reads late
    with emulated(speed=1.0, unplug=(1.0, 1e9)) as rig:
        done = record(port_of(rig), out, Settings(8.0, omega=13.09, reconnect=0.5))
    assert done.state == "unplugged"
    assert "unplugged" in done.fault
    assert "may still run" in done.fault
    assert 900 < len(table(out)) <= 1001


def test_a_rig_that_restarts_while_unplugged(tmp_path):
    out = tmp_path / "run.csv"
    with emulated(speed=2.0, unplug=(1.0, 1.0)) as rig:
        timer = threading.Timer(0.7, setattr, (rig.firmware, "_boot", 1))
        timer.start()
        done = record(port_of(rig), out, Settings(8.0, omega=13.09))
        timer.join()
    assert done.state == "restarted"
    assert 900 < len(table(out)) <= 1001


def test_a_rig_that_falls_silent(tmp_path):
    out = tmp_path / "run.csv"
    with emulated(speed=2.0) as rig:
        timer = threading.Timer(0.5, setattr, (rig.firmware, "running", False))
        timer.start()
        done = record(port_of(rig), out, Settings(8.0, omega=13.09, patience=0.5))
        timer.join()
    assert done.state == "silent"
    assert "fell silent" in done.fault
    assert done.rows == len(table(out)) > 100


def test_a_cable_out_further_on(tmp_path, monkeypatch):
    out = tmp_path / "run.csv"
    with emulated(speed=2.0) as rig:
        carry, begin = rig._line.carry, time.monotonic()
        monkeypatch.setattr(
            rig._line,
            "carry",
            lambda data: b"" if 0.6 < time.monotonic() - begin < 1.8 else carry(data),
        )
        done = record(port_of(rig), out, Settings(6.0, omega=13.09, patience=0.4))
    assert done.state == "complete"
    (gap,) = done.metadata["gaps"]
    assert gap["cause"] == "silent"
    assert gap["before"] - gap["after"] > 2.0
    assert len(table(out)) + gap["samples"] == 6001


def test_a_disk_that_is_full(tmp_path, monkeypatch):
    def full(fd, data):
        if len(data) > 200:
            raise OSError(errno.ENOSPC, "No space left on device")
        return os.write(fd, data)

    monkeypatch.setattr(writer, "os", SimpleNamespace(**{**vars(os), "write": full}))
    with emulated() as rig, pytest.raises(InputError, match=r"Cannot write .*run.csv: No space"):
        record(port_of(rig), tmp_path / "run.csv", Settings(2.0, omega=13.09))
    assert json.loads(metadata_path(tmp_path / "run.csv").read_text())["state"] == "failed"


def test_an_older_run_is_stopped_and_its_samples_ignored(tmp_path):
    with emulated(speed=2.0) as rig:
        rig.firmware._start(rig._now(), 3.0, None)  # what a killed recorder leaves behind
        until(lambda: rig.firmware.sent > 100)
        done = record(port_of(rig), tmp_path / "run.csv", Settings(1.0, release=0.4))
        check_no_wrong_sample(table(done.path), rig.firmware)
        assert rig.firmware.rig.started[-1] == (None, 0.4)
        assert not rig.firmware.running  # stopped in the end
    assert (done.omega, done.forced) == (None, False)
    assert done.metadata["drive"]["release"] == 0.4


@pytest.mark.parametrize("fault", ["no answer", "Ctrl-C"])
def test_a_rig_that_was_started_is_stopped(fault, tmp_path, monkeypatch):
    """Though nobody saw its answer to START."""
    monkeypatch.setattr("tp_jax.acquisition.device._OBEYED_WITHIN", 0.5)
    with emulated(speed=2.0) as rig:
        obey = rig.firmware._obey

        def unheard(command, now):
            answer = obey(command, now)
            return b"" if command.command == protocol.START else answer

        monkeypatch.setattr(rig.firmware, "_obey", unheard)
        expected: type[BaseException] = InputError
        if fault == "Ctrl-C":
            acknowledged = Device._acknowledged

            def interrupted(self, kind, values, patience):
                if kind == protocol.START:
                    acknowledged(self, kind, values, 0.3)
                    raise KeyboardInterrupt
                return acknowledged(self, kind, values, patience)

            monkeypatch.setattr(Device, "_acknowledged", interrupted)
            expected = KeyboardInterrupt
        with pytest.raises(expected):
            record(port_of(rig), tmp_path / "run.csv", Settings(2.0, omega=13.09))
        assert rig.firmware.rig.started == [(13.09, None)]
        assert not rig.firmware.running


@pytest.mark.parametrize("omega", [13.09, None])
def test_a_rig_that_does_not_say_that_it_stopped(omega, tmp_path, monkeypatch):
    with emulated(speed=5.0) as rig:
        obey = rig.firmware._obey
        unheard = lambda c, now: b"" if c.command == protocol.STOP else obey(c, now)  # noqa: E731
        monkeypatch.setattr(rig.firmware, "_obey", unheard)
        done = record(port_of(rig), tmp_path / "run.csv", Settings(0.5, omega=omega))
    assert done.state == "complete"
    assert done.metadata["notes"] == ([MAY_STILL_RUN] if omega else [])


def test_the_amplitude_is_commanded(tmp_path):
    with emulated(speed=5.0) as rig:
        record(port_of(rig), tmp_path / "run.csv", Settings(0.2, omega=2.0, amplitude=0.25))
        assert rig.firmware.rig.amplitude == 0.25


# The clock -----------------------------------------------------------------------------------


SKEW, NEAR = 2000e-6, 200e-6


def recorded_with_a_skew(out):
    """A recording of four seconds, and how fast the drive turned.

    Under load two of twelve are off by more than `NEAR`, since samples wait to be read: then it is
    made again, twice at the most.
    """
    for left in (2, 1, 0):
        with emulated(speed=1.0, skew=SKEW) as rig:
            done = record(port_of(rig), out, Settings(4.0, omega=10.0))
        if abs(done.metadata["clock"]["skew"] - SKEW) < NEAR:
            break
        for file in out.parent.iterdir() if left else ():
            file.unlink()
    return done, rig.firmware.rig.started[0][0]


def test_a_skew_is_corrected_and_sampling_stays_uniform(tmp_path, monkeypatch):
    monkeypatch.setattr("tp_jax.acquisition.recorder.SIGNIFICANT_ERRORS", 0.0)  # whatever the load
    out = tmp_path / "run.csv"
    # A rig does not share an interpreter with its recorder, and wait for its turn of 5 ms.
    turn = sys.getswitchinterval()
    sys.setswitchinterval(1e-4)
    try:
        done, driven = recorded_with_a_skew(out)
    finally:
        sys.setswitchinterval(turn)
    # the drive hangs on the same clock
    assert driven == pytest.approx(10.0 * (1.0 + SKEW))
    clock = done.metadata["clock"]
    assert clock["applied"]
    assert clock["skew"] == pytest.approx(SKEW, abs=NEAR)
    t = table(out)[:, 0]
    np.testing.assert_allclose(t, np.arange(4001) / 1000 / (1.0 + clock["skew"]), rtol=1e-15)
    assert np.ptp(np.diff(t)) < 1e-14
    assert done.omega == pytest.approx(10.0 * (1.0 + clock["skew"]), rel=1e-12)
    assert done.duration == pytest.approx(t[-1], rel=1e-12)


def test_the_frequency_goes_with_the_times_of_a_rig_that_fell_silent(tmp_path, monkeypatch):
    monkeypatch.setattr("tp_jax.acquisition.recorder.SIGNIFICANT_ERRORS", 0.0)
    skew = 0.1
    with emulated(speed=1.0, skew=skew) as rig:
        carry, begin = rig._line.carry, time.monotonic()
        monkeypatch.setattr(
            rig._line, "carry", lambda data: carry(data) if time.monotonic() - begin < 2.0 else b""
        )
        settings = Settings(60.0, omega=10.0, patience=0.3, reconnect=0.3)
        done = record(port_of(rig), tmp_path / "run.csv", settings)
    assert done.state == "silent"
    clock = done.metadata["clock"]
    assert clock["applied"]
    assert done.omega == pytest.approx(10.0 * (1.0 + clock["skew"]), rel=1e-12)


def test_times_that_cannot_be_corrected_stay(tmp_path, monkeypatch):
    """For want of room on the disk, for one; the recording is whole."""

    def full(path, factor):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("tp_jax.acquisition.recorder.scale_time", full)
    monkeypatch.setattr("tp_jax.acquisition.recorder.SIGNIFICANT_ERRORS", 0.0)
    out = tmp_path / "run.csv"
    with emulated(speed=1.0, skew=0.1) as rig:
        done = record(port_of(rig), out, Settings(1.5, omega=10.0))
    assert (done.state, done.omega) == ("complete", 10.0)
    assert not done.metadata["clock"]["applied"]
    assert "No space left" in " ".join(done.metadata["notes"])
    np.testing.assert_array_equal(table(out)[:, 0], np.arange(1501) / 1000)
    assert json.loads(metadata_path(out).read_text()) == done.metadata


def test_when_a_skew_is_corrected():
    d = np.arange(0.0, 60.0, 0.01)
    assert correction(None) == 1.0
    assert correction(fit_clock(d, d / (1.0 + 2e-4))) == pytest.approx(1.0 / (1.0 + 2e-4))
    assert correction(fit_clock(d, d / (1.0 + 4e-5))) == 1.0  # the host's clock is no better
    assert correction(fit_clock(d, 2.9 * d)) == 1.0  # no oscillator is so slow
    noisy = d[:500] + 1e-3 * np.random.default_rng(0).random(500)
    assert correction(fit_clock(d[:500], noisy / (1.0 + 2e-4), poll=1e-3)) == 1.0


# Text ----------------------------------------------------------------------------------------


def test_a_stream_of_text(tmp_path):
    out = tmp_path / "run.csv"
    with emulated(speed=2.0, rate=250.0, text=True, omega=5.0) as rig:
        done = record(port_of(rig), out, Settings(3.0, omega=5.0))
    rows = table(out)
    assert 748 <= len(rows) <= 752
    np.testing.assert_allclose(np.diff(rows[:, 0]), 0.004, atol=1e-9)
    np.testing.assert_allclose(rows[:, 1], 0.6 * np.sin(5.0 * rows[:, 0]), atol=0.006)
    meta = done.metadata
    assert (meta["stream"], meta["device"], done.state) == ("text", None, "complete")
    assert meta["drive"] == {"omega": 5.0, "amplitude": None, "release": None, "commanded": False}
    assert done.omega == 5.0


def test_volts_as_text(tmp_path):
    line = SensorCalibration("line", np.array([0.1, 2.0]), np.diag([1e-4, 0.0]))
    both = Calibration({"phi1": line, "phi2": line}, "rig.toml")
    with emulated(speed=2.0, rate=250.0, text=True, omega=5.0) as rig:
        done = record(port_of(rig), tmp_path / "a.csv", Settings(1.0, calibration=both))
        with pytest.raises(InputError, match=r"has no \[phi2\]"):
            record(
                port_of(rig),
                tmp_path / "b.csv",
                Settings(1.0, calibration=Calibration({"phi1": line}, "rig.toml")),
            )
    rows = table(done.path)
    np.testing.assert_allclose(rows[:, 1], (0.6 * np.sin(5.0 * rows[:, 0]) - 0.1) / 2.0, atol=0.004)
    assert done.metadata["calibration"]["phi1"]["standard_error"]["largest"] == pytest.approx(0.005)
    assert not (tmp_path / "b.csv").exists()


# Faults --------------------------------------------------------------------------------------


def test_nothing_comes(tmp_path):
    master, slave = os.openpty()
    with pytest.raises(InputError, match="Nothing came"):
        record(os.ttyname(slave), tmp_path / "run.csv", Settings(1.0, patience=0.5))
    os.close(master)
    os.close(slave)
    assert list(tmp_path.iterdir()) == []


def test_what_comes_is_noise(tmp_path):
    master, slave = os.openpty()
    stop = threading.Event()

    def babble():
        rng = np.random.default_rng(0)
        while not stop.wait(0.01):
            os.write(master, rng.integers(0, 256, 50, dtype=np.uint8).tobytes())

    thread = threading.Thread(target=babble)
    thread.start()
    try:
        with pytest.raises(InputError, match="neither frames nor lines"):
            record(os.ttyname(slave), tmp_path / "run.csv", Settings(1.0, patience=1.0))
    finally:
        stop.set()
        thread.join()
    os.close(master)
    os.close(slave)
    assert list(tmp_path.iterdir()) == []


def test_no_sample_comes(tmp_path):
    with emulated(speed=1.0, rate=0.001) as rig:
        rig.firmware.sample = lambda: (setattr(rig.firmware, "sent", 1), b"")[1]
        with pytest.raises(InputError, match="No sample came"):
            record(port_of(rig), tmp_path / "run.csv", Settings(5.0, patience=0.5))
    assert list(tmp_path.iterdir()) == []


def test_what_the_rig_refuses(tmp_path):
    class Weak:
        amplitude = 0.1

        def start(self, **options):
            raise InputError("no")

    with emulated() as rig:
        rig.firmware.rig = Weak()
        with pytest.raises(InputError, match="cannot do this value: release"):
            record(port_of(rig), tmp_path / "run.csv", Settings(1.0, release=0.5))
        with pytest.raises(InputError, match="cannot be told to drive at 1e"):
            record(port_of(rig), tmp_path / "run.csv", Settings(1.0, omega=1e9))


def test_a_rig_that_is_not_set_up(tmp_path):
    out = tmp_path / "run.csv"
    with emulated() as rig:
        rig.firmware.rate = 0.0
        with pytest.raises(InputError, match="sample rate"):
            record(port_of(rig), out, Settings(1.0))


def test_a_rig_of_another_version(tmp_path, monkeypatch):
    with emulated() as rig:
        monkeypatch.setattr("tp_jax.acquisition.device.protocol.VERSION", 2)
        with pytest.raises(InputError, match="speaks version 1"):
            record(port_of(rig), tmp_path / "run.csv", Settings(1.0))


def test_what_is_seen_beforehand(tmp_path):
    out = tmp_path / "run.csv"
    with pytest.raises(InputError, match="omega or release"):
        record("none", out, Settings(1.0, omega=1.0, release=1.0))
    with pytest.raises(InputError, match="above zero"):
        record("none", out, Settings(0.0))
    with pytest.raises(InputError, match="Cannot open the port"):
        record(str(tmp_path / "none"), out, Settings(1.0))
    metadata_path(out).write_text("{}")
    with pytest.raises(InputError, match=r"run.csv.meta.json already"):
        record("none", out, Settings(1.0))


def test_a_port_is_not_shared(tmp_path):
    with emulated() as rig:
        first = port_of(rig)
        with pytest.raises(InputError, match="another program"):
            record(rig.port, tmp_path / "run.csv", Settings(1.0))
        first.close()


# Death ------------------------------------------------------------------------------

PROGRAM = """
import sys
from tp_jax.acquisition import Settings, record
record(sys.argv[1], sys.argv[2], Settings(float(sys.argv[3]), omega=13.09))
"""


def test_a_killed_recorder_leaves_all_but_the_last_moment(tmp_path):
    out = tmp_path / "run.csv"
    # a rig four times slower than its clock: the recorder may wait long for a busy processor
    with (
        emulated(speed=0.25) as rig,
        running([sys.executable, "-c", PROGRAM, rig.port, str(out), "60"]) as child,
    ):
        until(lambda: out.exists() and out.stat().st_size > 10_000)
        sent = rig.firmware.sent
        child.send_signal(signal.SIGKILL)
        child.wait()
        firmware = rig.firmware
    rows = table(out)
    assert sent - len(rows) <= 100  # 0.1 s at 1 kHz
    check_no_wrong_sample(rows, firmware)
    assert out.read_bytes().endswith(b"\n")
    assert load_campaign(out, omega=13.09).recordings[0].n == len(rows)
    meta = json.loads(metadata_path(out).read_text())
    assert meta["state"] == "recording"
    assert meta["device"]["rate"] == 1000.0


@pytest.mark.parametrize("by", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_interrupting_keeps_what_there_is(by, tmp_path):
    """And the motor stands, also where the program is told to end or its terminal is closed."""
    out = tmp_path / "run.csv"
    with (
        emulated(speed=1.0) as rig,
        running([sys.executable, "-c", PROGRAM, rig.port, str(out), "60"]) as child,
    ):
        until(lambda: out.exists() and out.stat().st_size > 20_000)
        child.send_signal(by)
        assert child.wait(PATIENCE) == 0
        assert not rig.firmware.running
    meta = json.loads(metadata_path(out).read_text())
    assert meta["state"] == "interrupted"
    assert meta["samples"]["written"] == len(table(out)) > 300
