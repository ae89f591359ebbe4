"""Progress is shown on a terminal, and only there."""

import contextlib
import json
import os
import pty
import sys

from tp_jax.cli.progress import shown, silent


def test_silent_elsewhere(capsys):
    with shown(quiet=False) as progress:
        progress("fitting", 0.5)
        assert progress is silent
    told = capsys.readouterr()
    assert told.out == told.err == ""


def test_lines_for_a_program(capsys):
    with shown(quiet=True, lines=True) as progress:
        progress("fitting windows of 0.5 s", 0.5)
        progress("polishing φ", None)
    told = capsys.readouterr()
    assert told.out == ""
    assert [json.loads(line) for line in told.err.splitlines()] == [
        {"stage": "fitting windows of 0.5 s", "part": 0.5},
        {"stage": "polishing φ", "part": None},
    ]


def test_shown_on_a_terminal(monkeypatch):
    leader, follower = pty.openpty()
    with open(follower, "w") as terminal:
        monkeypatch.setattr(sys, "stderr", terminal)
        monkeypatch.setenv("TERM", "xterm")
        with shown(quiet=True) as progress:
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
