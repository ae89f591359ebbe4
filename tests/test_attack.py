"""scripts/attack: a short one finds nothing, and what is a fault is counted as one."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from scripts._attack import commands, readers, tally
from scripts._attack.tally import Tally
from tp_jax.errors import InputError

ROOT = Path(__file__).parents[1]


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


def alone(program: str) -> str:
    """What a program prints in an interpreter of its own: kills fork, and JAX has threads here."""
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True, cwd=ROOT
    )
    return done.stdout


def test_kills():
    told = alone(
        "from scripts._attack import kills, tally\n"
        "kills.RECORDINGS = 0.0\n"
        "found = tally.Tally()\n"
        "kills.attack(found, 10)\n"
        "print(*found.lines(), sep='\\n')\n"
        "print('faults:', found.faults)\n"
    )
    assert told.endswith("faults: 0\n"), told


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


def test_half_a_file_is_found(tmp_path):
    """The kills would tell where a file is not replaced as a whole.

    A file written in place is half there for microseconds, which twelve kills may all miss: this
    one is half there for most of the time.
    """
    told = alone(
        "import contextlib, pathlib, random, time\n"
        "from scripts._attack import kills, tally\n"
        "import tp_jax.cli.output as output\n"
        "class InPlace(type(pathlib.Path())):\n"
        "    def write_text(self, text, **_):\n"
        "        with self.open('w') as file:\n"
        "            file.write(text[: len(text) // 2])\n"
        "            file.flush()\n"
        "            time.sleep(0.005)\n"
        "            file.write(text[len(text) // 2 :])\n"
        "output._files.replaced = lambda target: contextlib.nullcontext(InPlace(target))\n"
        "found, chance = tally.Tally(), random.Random(0)\n"
        "for i in range(12):\n"
        f"    folder = pathlib.Path({str(tmp_path)!r}, str(i))\n"
        "    folder.mkdir()\n"
        "    found.attempt('result', lambda: kills._result(folder, chance))\n"
        "print('faults:', found.faults)\n"
    )
    assert int(told.split()[-1]) > 0
