"""scripts/attack: a short one finds nothing, and what is a fault is counted as one."""

import contextlib
import os
import random
import time
from pathlib import Path

import pytest

from scripts._attack import commands, kills, readers, tally
from scripts._attack.tally import Tally
from tp_jax.errors import InputError


def nothing(found: Tally) -> None:
    assert found.faults == 0, "\n".join(found.lines())


@pytest.mark.parametrize("door", sorted(readers.readers()))
def test_readers(door):
    found = Tally()
    readers.attack(found, 30, only=door)
    nothing(found)
    (row,) = found.rows.values()
    assert row.tried == row.refused + row.done >= 20


def test_commands():
    found, here = Tally(), os.getcwd()
    commands.attack(found, 80)
    nothing(found)
    assert os.getcwd() == here
    assert sum(row.refused for row in found.rows.values()) > 40


def test_kills(monkeypatch):
    monkeypatch.setattr(kills, "RECORDINGS", 0.0)
    found = Tally()
    kills.attack(found, 10)
    nothing(found)


def raising(fault):
    raise fault


@pytest.mark.parametrize(
    ("work", "counts"),
    [
        (lambda: None, (0, 1, 0)),
        (lambda: raising(InputError("No.")), (1, 0, 0)),
        (lambda: raising(InputError("No.\nNot.")), (1, 0, 1)),
        (lambda: raising(KeyError("x")), (0, 0, 1)),
        (lambda: time.sleep(5.0), (0, 0, 1)),
    ],
)
def test_what_is_counted(work, counts, monkeypatch):
    monkeypatch.setattr(tally, "LONGEST", 0.05)
    found = Tally()
    found.attempt("a door", work, "what was tried")
    row = found.rows["a door"]
    assert (row.refused, row.done, found.faults) == counts
    assert f"fault, a door, {counts[2]} times" in "\n".join(found.lines()) or not counts[2]


def test_a_reader_that_breaks_is_found(monkeypatch):
    monkeypatch.setattr("tp_jax.recordings.load_campaign", lambda *_, **__: raising(OSError("x")))
    found = Tally()
    readers.attack(found, 20, only="recording")
    assert found.faults == found.rows["reader: recording"].tried


def test_half_a_file_is_found(monkeypatch, tmp_path):
    """The kills would tell where a file is not replaced as a whole."""

    @contextlib.contextmanager
    def in_place(target):
        yield Path(target)

    monkeypatch.setattr("tp_jax.cli.output._files.replaced", in_place)
    found, chance = Tally(), random.Random(0)
    for i in range(12):
        (tmp_path / str(i)).mkdir()
        found.attempt("result", lambda i=i: kills._result(tmp_path / str(i), chance))
    assert found.faults > 0
