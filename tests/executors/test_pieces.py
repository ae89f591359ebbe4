"""Pieces in processes of this machine: faults, deaths, what is kept, killed drivers."""

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path

import pytest

from scripts._executors import Hand, begun_times
from tests.executors import stand_in
from tests.executors.stand_in import some_pieces, summed
from tests.waiting import running, until
from tp_jax.executors import ExecutorChoice, Piece, done_before, forget_pieces, run_pieces
from tp_jax.executors.calls import Fault

ROOT = Path(__file__).parent.parent.parent
TWO = ExecutorChoice("local", 2)


def run(work, pieces, **options):
    """What ended, by key."""
    ended = list(run_pieces(work, pieces, TWO, uses_jax=False, **options))
    assert len({each.piece.key for each in ended}) == len(ended), "each ends once"
    return {each.piece.key: each for each in ended}


def test_faults_come_back_and_the_others_go_on():
    ended = run(stand_in.failing, [Piece(f"p{i}", (i,)) for i in range(4)])
    assert [ended[f"p{i}"].result for i in range(4)] == [0, None, 2, None]
    fault = ended["p1"].fault
    assert str(fault) == "ValueError: 1 is odd"
    assert not fault.of_input
    assert "in failing" in fault.trace


def test_a_fault_of_the_input_is_known_as_one():
    fault = run(stand_in.asked_for_more, [Piece("p")])["p"].fault
    assert fault.of_input
    assert fault.text == "The file run.csv has no column t; add one."


def test_work_that_cannot_be_imported_is_a_fault_of_its_piece(tmp_path, monkeypatch):
    (tmp_path / "passing.py").write_text("def work():\n    return 1\n")
    monkeypatch.syspath_prepend(tmp_path)
    import passing

    assert run(passing.work, [Piece("p")])["p"].result == 1
    (tmp_path / "passing.py").unlink()
    assert run(passing.work, [Piece("p")])["p"].fault.kind == "ModuleNotFoundError"


def test_workers_stay_each_on_one_processor():
    ended = run(stand_in.where, [Piece(f"p{i}") for i in range(6)])
    pids, processors = zip(*(each.result for each in ended.values()), strict=True)
    assert len(set(pids)) <= 2
    assert os.getpid() not in pids
    assert set(processors) == {1}


def test_other_workers_take_over_after_so_many_pieces():
    ended = run(stand_in.where, [Piece(f"p{i}") for i in range(6)], pieces_per_worker=1)
    assert len({each.result[0] for each in ended.values()}) == 6


def test_none_begins_too_late(tmp_path):
    pieces = some_pieces(2, tmp_path / "begun")
    assert run(summed, pieces, until=time.monotonic() - 1.0) == {}


def test_what_is_kept_is_not_done_again(tmp_path):
    pieces = some_pieces(3, tmp_path / "begun")
    first = run(summed, pieces, folder=tmp_path)
    again = run(summed, pieces, folder=tmp_path)
    assert begun_times(tmp_path / "begun") == {0: 1, 1: 1, 2: 1}
    assert {k: e.result for k, e in again.items()} == {k: e.result for k, e in first.items()}
    assert all(each.kept for each in again.values())
    assert not any(each.kept for each in first.values())
    assert done_before(tmp_path, pieces) == pieces
    # of something else, spoiled, or to be forgotten: done anew
    other = [Piece(each.key, each.arguments, of="other data") for each in pieces]
    assert done_before(tmp_path, other) == []
    (tmp_path / "pieces" / "piece-0.json").write_text('{"schema": "tp-jax/pie')
    assert done_before(tmp_path, pieces) == pieces[1:]
    forget_pieces(tmp_path, pieces[1:2])
    assert done_before(tmp_path, pieces) == pieces[2:]


def test_a_fault_is_not_kept(tmp_path):
    assert run(stand_in.failing, [Piece("p", (1,))], folder=tmp_path)["p"].fault is not None
    assert not (tmp_path / "pieces").exists()


def test_keys_name_files_once():
    for key in ("", "a/b", "..", "a b", "x" * 300):
        with pytest.raises(ValueError, match="cannot name a file"):
            Piece(key)
    with pytest.raises(ValueError, match="Two pieces have the key 'p'"):
        run(stand_in.where, [Piece("p"), Piece("p")])


def test_a_piece_that_kills_its_workers_is_given_up_and_the_others_are_done():
    pieces = [Piece("bad"), *(Piece(f"p{i}") for i in range(3))]
    ended = {}
    for work, some in ((stand_in.ends_itself, pieces[:1]), (stand_in.where, pieces[1:])):
        ended |= run(work, some)
    assert ended["bad"].fault.kind == "WorkerLost"
    assert ended["bad"].fault.text.startswith("5 workers died of it")
    assert all(ended[f"p{i}"].fault is None for i in range(3))


@pytest.mark.slow
def test_killed_workers_lose_nothing(tmp_path):
    pieces = some_pieces(12, tmp_path / "begun")
    with Hand(tmp_path / "begun", times=3, every_s=0.2) as hand:
        ended = run(summed, pieces, folder=tmp_path)
    assert len(hand.killed) == 3
    assert all(each.fault is None for each in ended.values())
    for each in pieces:
        assert ended[each.key].result == summed(*each.arguments[:1], tmp_path / "begun")
    # one more by this process, and one for each death
    assert sum(begun_times(tmp_path / "begun").values()) <= 12 + 12 + 3


@pytest.mark.slow
@pytest.mark.parametrize("which", ["the driver", "all"])
def test_a_killed_study_goes_on(tmp_path, which):
    words = [sys.executable, "-m", "tests.executors.driver", str(tmp_path), "8"]
    options = {"cwd": ROOT, "stdout": subprocess.PIPE, "text": True, "start_new_session": True}
    with running(words, **options) as process:
        for _ in range(3):  # pieces have ended
            assert process.stdout.readline()
        if which == "all":
            os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()
    begun = tmp_path / "begun"
    workers = {int(pid) for f in begun.glob("*.txt") for pid in f.read_text().split()}
    until(lambda: not any(map(alive, workers)))  # they end with the driver
    done = {f.stem for f in (tmp_path / "pieces").glob("[!.]*.json")}
    assert 3 <= len(done) < 8
    before = begun_times(begun)
    again = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True)
    said = dict(line.split() for line in again.stdout.splitlines())
    assert len(said) == 8
    assert {key for key, kept in said.items() if kept == "True"} == done
    after = begun_times(begun)
    assert all(after[i] == before[i] for i in range(8) if f"piece-{i}" in done)
    for i in range(8):
        kept = json.loads((tmp_path / "pieces" / f"piece-{i}.json").read_text())["result"]
        assert kept == summed(i, begun)


def alive(pid: int) -> bool:
    """Whether a process is there and has not ended."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def test_a_study_that_is_left_ends_at_once():
    begin = time.monotonic()
    pieces = [Piece("short", (0.0,)), Piece("long", (600.0,))]
    with closing(run_pieces(time.sleep, pieces, TWO)) as ended:
        assert next(ended).piece.key == "short"
    assert time.monotonic() - begin < 300.0


def test_a_fault_is_one_line():
    assert str(Fault.of(RuntimeError("two\n  lines"))) == "RuntimeError: two lines"
