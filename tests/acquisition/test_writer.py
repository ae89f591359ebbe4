"""The file, written as it comes."""

import errno
import os
import signal
import subprocess
import sys
import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest

from tests.waiting import PATIENCE, until
from tp_jax._files import replaced
from tp_jax.acquisition import writer as module
from tp_jax.acquisition.writer import CsvWriter, scale_time
from tp_jax.errors import InputError
from tp_jax.recordings import read_columns

NAMES = ("t", "phi1", "phi2")


def rows(n, first=0):
    t = (first + np.arange(n)) / 1000
    return np.column_stack([t, np.sin(t), np.cos(t)])


def test_what_is_read_back_is_what_was_written(tmp_path):
    path = tmp_path / "new" / "run.csv"
    writer = CsvWriter(path, NAMES)
    for first in range(0, 1000, 100):
        writer.write(rows(100, first))
        # there for everybody at once, not when the file is closed
        assert len(path.read_bytes().splitlines()) == 1 + first + 100
    writer.write(rows(0))
    writer.close()
    writer.close()
    assert writer.rows == 1000
    assert path.read_text().startswith("t,phi1,phi2\n0,0,1\n")
    values = read_columns(path).values
    np.testing.assert_array_equal(np.column_stack([values[n] for n in NAMES]), rows(1000))


def test_no_file_is_written_over(tmp_path):
    path = tmp_path / "run.csv"
    path.write_text("mine")
    with pytest.raises(InputError, match="already"):
        CsvWriter(path, NAMES)
    assert path.read_text() == "mine"
    with pytest.raises(InputError, match="Cannot write"):
        CsvWriter(path / "below" / "run.csv", NAMES)


def filling(monkeypatch, room):
    """A disk that has room for so many bytes more."""
    left = [room]

    def write(fd, data):
        if not left[0]:
            raise OSError(errno.ENOSPC, "No space left on device")
        done = os.write(fd, data[: left[0]])
        left[0] -= done
        return done

    monkeypatch.setattr(module, "os", SimpleNamespace(**{**vars(os), "write": write}))


def test_no_number_is_cut_in_two_where_the_disk_is_full(tmp_path, monkeypatch):
    path = tmp_path / "run.csv"
    writer = CsvWriter(path, NAMES)
    writer.write(rows(10))
    before = path.read_bytes()
    filling(monkeypatch, 77)
    with pytest.raises(OSError, match="No space"):
        writer.write(rows(10, 10))
    writer.close()
    assert path.read_bytes() == before
    assert writer.rows == 10


def test_a_file_that_has_no_room_for_a_header_goes(tmp_path, monkeypatch):
    path = tmp_path / "run.csv"
    filling(monkeypatch, 3)
    with pytest.raises(InputError, match="No space"):
        CsvWriter(path, NAMES)
    assert not path.exists()


def test_the_disk_is_asked_once_in_a_while(tmp_path, monkeypatch):
    calls, fsync = [], os.fsync
    monkeypatch.setattr(module, "SYNC_PERIOD", 0.02)
    monkeypatch.setattr(module.os, "fsync", lambda fd: (calls.append(fd), fsync(fd)))
    writer = CsvWriter(tmp_path / "run.csv", NAMES)
    begin = time.monotonic()
    until(lambda: len(calls) >= 3)
    assert len(calls) <= 1 + (time.monotonic() - begin) / 0.02
    writer.close()


def test_a_slow_disk_keeps_nobody_waiting(tmp_path):
    slow, begun, done = threading.Event(), threading.Event(), []

    def job():
        begun.set()
        slow.wait(PATIENCE)
        done.append(True)

    writer = CsvWriter(tmp_path / "run.csv", NAMES)
    writer.beside(job)
    assert begun.wait(PATIENCE)
    writer.write(rows(10))
    for _ in range(3):
        writer.beside(job)
    assert (done, writer.rows) == ([], 10)
    slow.set()
    writer.close()
    assert len(done) == 2  # those that came meanwhile are one


def test_a_killed_process_leaves_every_block(tmp_path):
    path = tmp_path / "run.csv"
    program = (
        "import sys, time, numpy as np\n"
        "from pathlib import Path\n"
        "from tp_jax.acquisition.writer import CsvWriter\n"
        f"writer = CsvWriter(Path({str(path)!r}), ('t', 'phi1', 'phi2'))\n"
        "for n in range(10**9):\n"
        "    writer.write(np.full((10, 3), float(n)))\n"
        "    print(n, flush=True)\n"
    )
    child = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    said = [child.stdout.readline() for _ in range(200)]
    child.send_signal(signal.SIGKILL)
    said += child.stdout.read().splitlines()
    child.wait()
    child.stdout.close()
    lines = path.read_text().splitlines()
    assert len(lines) >= 1 + 10 * (len(said) - 1)
    assert {line.count(",") for line in lines} == {2}


def test_scaling_time_changes_nothing_else(tmp_path):
    path = tmp_path / "run.csv"
    writer = CsvWriter(path, NAMES)
    writer.write(rows(500))
    writer.close()
    scale_time(path, 1.0 / 1.0002)
    values = read_columns(path).values
    np.testing.assert_array_equal(values["t"], rows(500)[:, 0] * (1.0 / 1.0002))
    np.testing.assert_array_equal(values["phi1"], rows(500)[:, 1])
    assert np.ptp(np.diff(values["t"])) < 1e-15  # uniform as before
    assert [each.name for each in tmp_path.iterdir()] == ["run.csv"]


def test_replacing_keeps_links_and_permissions(tmp_path):
    real, link = tmp_path / "real.toml", tmp_path / "link.toml"
    real.write_text("old")
    real.chmod(0o640)
    link.symlink_to(real)
    with replaced(link) as part:
        part.write_text("new")
    assert link.is_symlink()
    assert real.read_text() == "new"
    assert real.stat().st_mode & 0o777 == 0o640
