"""Boards that print lines with one thing wrong: what is mended, and what is said of the rest."""

import itertools
import json
import math
import os
import select
import threading
import time
import tty
from contextlib import contextmanager

import numpy as np
import pytest

from tp_jax.acquisition.timeline import Timeline
from tp_jax.cli import main
from tp_jax.errors import InputError
from tp_jax.recordings import read_columns

RATE = 250.0


@contextmanager
def board(line):
    """A board that prints line(t) so often a second from when it is first asked; its port.

    A line waits until there is room for it: a busy host reads late, and loses none.
    """
    master, slave = os.openpty()
    tty.setraw(master)
    tty.setraw(slave)
    os.set_blocking(master, False)
    stop = threading.Event()

    def prints():
        while not select.select([master], [], [], 0.02)[0]:
            if stop.is_set():
                return
        begin = time.monotonic()
        for i in itertools.count():
            rest = line(i / RATE) + b"\r\n"
            wait = begin + i / RATE - time.monotonic()
            while rest:
                if stop.wait(max(wait, 0.0)):
                    return
                try:
                    rest, wait = rest[os.write(master, rest) :], 0.0
                except BlockingIOError:
                    wait = 1e-3

    thread = threading.Thread(target=prints)
    thread.start()
    try:
        yield os.ttyname(slave)
    finally:
        stop.set()
        thread.join()
        os.close(master)
        os.close(slave)


def recorded(line, out, capsys, duration="1"):
    """Exit code, times, and what was printed and complained of."""
    with board(line) as port:
        code = main(
            ["record", "--port", port, "--duration", duration, "--patience", "1", "--out", str(out)]
        )
    told = capsys.readouterr()
    return code, read_columns(out).values["t"] if out.exists() else None, told.out, told.err


def printed(t, digits=6):
    return f"{t:.{digits}f} {0.3 * math.sin(9.0 * t):.5f} {0.2 * math.sin(7.0 * t):.5f}".encode()


def counted(count):
    return f"{count} 0.1 0.2".encode()


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (lambda t: printed((4294.967296 - 0.5 + t) % 4294.967296), "wrapped at"),
        (
            lambda t: printed((2147.483648 - 0.5 + t + 2147.483648) % 4294.967296 - 2147.483648),
            "wrapped at",
        ),
        (lambda t: counted(round(1e6 * t)), "times are microseconds; they are written in seconds"),
        (lambda t: counted(round(1e3 * t)), "times are milliseconds; they are written in seconds"),
        (lambda t: counted(round(1e6 * t + 2**31 - 1.2e6 + 2**31) % 2**32 - 2**31), "wrapped at"),
        (lambda t: counted(round(1e3 * t + 2**32 - 1.2e3) % 2**32), "wrapped at"),
    ],
)
def test_counters_that_wrap_or_are_no_seconds(line, said, tmp_path, capsys):
    out = tmp_path / "run.csv"
    code, t, told, fault = recorded(line, out, capsys, "1.5")
    assert (code, fault) == (0, "")
    assert said in told
    assert t.size == 376
    np.testing.assert_allclose(np.diff(t), 1 / RATE, atol=1e-6)
    meta = json.loads((tmp_path / "run.csv.meta.json").read_text())
    assert meta["samples"]["lost"] == meta["samples"]["implausible"] == 0
    assert any(said in note for note in meta["notes"])


def test_rounded_times_are_no_recording(tmp_path, capsys):
    out = tmp_path / "run.csv"
    code, t, told, fault = recorded(lambda t: printed(t, 2), out, capsys)
    assert code == 2
    assert told.startswith(f"Wrote {out}: ")
    assert fault.count("\n") == 1
    assert "is not what was asked for" in fault
    assert "rows were left out, since their time is that of the one before" in fault
    assert "rounded to 0.01 s; print more digits of it" in fault
    meta = json.loads((tmp_path / "run.csv.meta.json").read_text())
    assert meta["samples"]["implausible"] == pytest.approx(1.5 * t.size, rel=0.1)


def test_a_recording_with_much_left_out_stays_out_of_the_campaign(tmp_path, capsys):
    folder = tmp_path / "rig"
    with board(lambda t: printed(t, 2)) as port:
        assert main(["record", "--port", port, "--duration", "1", "--campaign", str(folder)]) == 2
    told = capsys.readouterr()
    assert "Added" not in told.out
    assert f"Not added to the campaign {folder}: Too much of it is missing" in told.err
    assert [each.suffix for each in sorted(folder.iterdir())] == [".csv", ".json"]


def test_a_board_that_restarts_does_not_wrap(tmp_path, capsys):
    out, begin = tmp_path / "run.csv", 4200.0
    code, t, told, fault = recorded(
        lambda t: printed(begin + t if t < 1.0 else t - 1.0), out, capsys, "3"
    )
    assert code == 2
    assert "the rig has restarted" in fault
    assert "wrapped" not in told
    assert t[-1] < begin + 1.0


@pytest.mark.parametrize(
    ("line", "shown", "mend"),
    [
        (lambda t: f"t:{t:.4f},phi1:0.1,phi2:0.2".encode(), ',phi1:0.1,phi2:0.2"', "print lines"),
        (lambda t: f"{t:.4f};0,1;0,2".replace(".", ",").encode(), ';0,1;0,2"', "print lines"),
        (lambda t: b"\x00\xf8\xe0\xfe\x80\x78" * 4, r"\xf8\xe0\xfe\x80x", "give the rig's own --b"),
    ],
)
def test_a_line_of_what_cannot_be_read_is_shown(line, shown, mend, tmp_path, capsys):
    code, t, told, fault = recorded(line, tmp_path / "run.csv", capsys)
    assert (code, t, told) == (2, None, "")
    assert shown in fault
    assert mend in fault
    assert fault.count("\n") == 1


def test_a_time_that_stands_still_is_said(tmp_path, capsys):
    code, t, _, fault = recorded(lambda t: b"7 0.1 0.2", tmp_path / "run.csv", capsys, "2")
    assert (code, t) == (2, None)
    assert "The first number of each line rises by 0 in a second, which is no time" in fault


# The timeline alone ---------------------------------------------------------------------------


def fed(timeline, t, size=7, rate=RATE):
    """Times for printed ones, the host's clock going on by 1/rate with each."""
    rows = np.column_stack([t, np.sin(t)])
    parts = [timeline.feed_rows(rows[i : i + size], i / rate) for i in range(0, len(rows), size)]
    return np.concatenate([part[:, 0] for part in parts])


@pytest.mark.parametrize("wrap", [2.0**31, 2.0**32])
@pytest.mark.parametrize("unit", [1e3, 1e6])
@pytest.mark.parametrize("in_seconds", [False, True])
@pytest.mark.parametrize("gap", [0, 40])
def test_a_wrap_is_carried_on(wrap, unit, in_seconds, gap):
    t = wrap / unit - 1.0 + np.delete(np.arange(600) / RATE, range(250 - gap // 2, 250 + gap // 2))
    count = np.rint(t * unit) % wrap
    timeline = Timeline()
    got = fed(timeline, count / unit if in_seconds else count)
    np.testing.assert_allclose(got, t, atol=1e-8)
    assert timeline.wraps == [pytest.approx(got[np.argmax(t >= wrap / unit)])]
    assert (timeline.lost, timeline.implausible, timeline.restarted) == (gap, 0, False)
    assert timeline.unit == (
        "seconds" if in_seconds else {1e3: "milliseconds", 1e6: "microseconds"}[unit]
    )


@pytest.mark.parametrize("uptime", [50.0, 2000.0, 4000.0])
def test_a_restart_is_no_wrap(uptime):
    timeline = Timeline()
    fed(timeline, np.concatenate([uptime + np.arange(300) / RATE, np.arange(20) / RATE]))
    assert timeline.restarted
    assert timeline.wraps == []


def test_one_damaged_time_is_no_wrap():
    t = 4294.5 + np.arange(100) / RATE
    damaged = t.copy()
    damaged[50] = 0.25  # would be a little ahead, were it one
    timeline = Timeline()
    np.testing.assert_array_equal(fed(timeline, damaged), np.delete(t, 50))
    assert (timeline.wraps, timeline.implausible) == ([], 1)


def test_a_number_that_is_no_time_is_refused():
    with pytest.raises(InputError, match="rises by 250 in a second"):
        fed(Timeline(), np.arange(1000.0))


def test_a_slow_rig_may_count_seconds():
    timeline = Timeline()
    got = fed(timeline, np.arange(20.0), size=1, rate=1.0)
    np.testing.assert_array_equal(got, np.arange(20.0))
    assert timeline.unit == "seconds"
