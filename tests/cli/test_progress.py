"""Progress: bars on a terminal and only there, lines of text or JSON where they are asked for."""

import contextlib
import io
import json
import os
import pty
import sys

import pytest

from tp_jax.cli import build_parser
from tp_jax.cli.progress import State, Watch, _lines, clock, shown, silent


def test_silent_elsewhere(capsys):
    with shown(quiet=False) as progress:
        progress("fitting", 0.5)
        assert progress is silent
    told = capsys.readouterr()
    assert told.out == told.err == ""


def test_shown_on_a_terminal(monkeypatch):
    leader, follower = pty.openpty()
    with open(follower, "w") as terminal:
        monkeypatch.setattr(sys, "stderr", terminal)
        monkeypatch.setenv("TERM", "xterm")
        with shown(quiet=True) as progress:
            assert progress is silent
        with shown(quiet=False, form="none") as progress:
            assert progress is silent
        with shown(quiet=False) as progress:
            progress("fitting", None)
            progress("fitting", 0.5)
            progress("screening", 0.1)
    text = ""
    with contextlib.suppress(OSError):  # how a pseudo-terminal says that nobody writes any more
        while more := os.read(leader, 65536).decode():
            text += more
    os.close(leader)
    assert "fitting" in text or "screening" in text


@pytest.mark.parametrize("quiet", [False, True])
def test_json_is_an_object_a_line(capsys, quiet):
    with shown(quiet=quiet, form="json") as progress:
        progress("preparing", None)
        progress("refitting: é, 1 of 2", 0.0)
        progress("refitting: b, 2 of 2", 0.5)
        progress("refitting: b, 2 of 2", 0.6)  # too soon after the last
    told = capsys.readouterr()
    lines = [json.loads(line) for line in told.err.splitlines()]
    assert told.out == ""
    assert [line["stage"] for line in lines] == [
        "preparing",
        "refitting: é, 1 of 2",
        "refitting: b, 2 of 2",
    ]
    assert [line["part"] for line in lines] == [None, 0.0, 0.5]
    assert all(list(line) == ["stage", "part", "elapsed_s", "left_s"] for line in lines)
    assert all(line["elapsed_s"] >= 0.0 and line["left_s"] is None for line in lines)


class Clock:
    """A clock that a test sets."""

    def __init__(self):
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


def test_lines_of_text_keep_their_distance(monkeypatch):
    now, stream = Clock(), io.StringIO()
    monkeypatch.setattr("tp_jax.cli.progress.Watch", lambda: Watch(now))
    report = _lines(stream, State.to_text, 10.0, each_stage=False)
    for now.now in (0.0, 1.0, 9.9, 10.0, 12.0, 19.9, 25.0):
        report("fitting: a", now.now / 100.0)
    assert stream.getvalue().splitlines() == [
        "0:00  fitting: a, 0 %",
        "0:10  fitting: a, 10 %, 1:30 left",
        "0:25  fitting: a, 25 %, 1:15 left",
    ]


def test_the_time_left_is_that_of_the_stage():
    now = Clock()
    watch = Watch(now)
    assert watch.at("starts, 9 in all", 0.5).left_s is None  # resumed: half was there
    now.now = 10.0
    assert watch.at("starts, 9 in all", 0.75).left_s == pytest.approx(10.0)
    assert watch.at("optima", 0.0).left_s is None
    now.now = 14.0
    state = watch.at("optima: the second", 0.25)
    assert (state.left_s, state.elapsed_s) == (pytest.approx(12.0), 14.0)
    assert watch.at("optima: the second", None).left_s is None
    assert watch.at("optima: the third", 1.3).part == 1.0
    assert watch.at("optima: anew", 0.0).left_s is None  # another round of the same


def test_a_reader_that_has_gone_ends_nothing():
    stream = io.StringIO()
    report = _lines(stream, State.to_json, 0.0, each_stage=True)
    stream.close()
    report("fitting", 0.5)


@pytest.mark.parametrize(("seconds", "told"), [(7.4, "0:07"), (750, "12:30"), (3723, "1:02:03")])
def test_clock(seconds, told):
    assert clock(seconds) == told


@pytest.mark.parametrize("command", ["diagnose c", "identify c", "sensitivity c"])
def test_long_commands_take_it(command):
    args = build_parser().parse_args([*command.split(), "--progress", "json"])
    assert args.progress == "json"
