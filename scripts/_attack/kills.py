"""Processes killed (SIGKILL) at random moments while they write: nothing that was there is lost."""

import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from scripts._attack import corpus
from scripts._attack.tally import Tally, Wrong

RECORDINGS = 0.1
"""Part of the kills that are of whole recordings, which take seconds each."""

LONGEST_LIFE = 0.08
"""Seconds until a process that only writes is killed."""


def attack(tally: Tally, kills: int, seed: int = 0) -> None:
    """Makes so many kills, shared among those that write. Before threads are there: it forks."""
    chance = random.Random(seed)
    recordings = round(RECORDINGS * kills)
    doors: dict[str, Callable[[Path, random.Random], None]] = {
        "starts": _starts,
        "program in the cache": _program,
        "campaign's entry": _entry,
        "result": _result,
        "parts of a trial": _trial,
    }
    for i in range(kills - recordings):
        door, work = list(doors.items())[i % len(doors)]
        with tempfile.TemporaryDirectory() as folder:
            tally.attempt(f"kill: {door}", lambda w=work, f=folder: w(Path(f), chance), f"no. {i}")
    for i in range(recordings):
        with tempfile.TemporaryDirectory() as folder:
            tally.attempt("kill: recording", lambda f=folder: _recording(Path(f), chance), i)


def killed(work: Callable[[Callable[[int], None]], None], life: float) -> int:
    """Does the work in a process that is killed; the last number that it said was done.

    Args:
        work: takes a function to say so with, and goes on for ever.
        life: seconds.
    """
    read, write = os.pipe()
    child = os.fork()
    if not child:
        os.close(read)
        os.setsid()  # what it starts dies with it
        try:
            work(lambda n: os.write(write, n.to_bytes(4, "little")) and None)
        finally:
            os._exit(1)
    os.close(write)
    time.sleep(life)
    for kill in (os.killpg, os.kill):  # no group yet, if it was killed in being born
        with suppress(ProcessLookupError):
            kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    said = b""
    while piece := os.read(read, 65536):
        said += piece
    os.close(read)
    return int.from_bytes(said[-4:], "little") if said else 0


def _starts(folder: Path, chance: random.Random) -> None:
    """Checks that what a search said it kept is there, and nothing else."""
    from tp_jax.estimation.checkpoint import Checkpoint

    given, file = corpus.starts(), folder / "starts.json"

    def search(say: Callable[[int], None]) -> None:
        kept = Checkpoint(file, given["key"])
        for n in range(1, 10**6):
            kept.put({f"start {n}": given["done"]["start 0"]})
            say(n)

    done = killed(search, chance.uniform(0.0, LONGEST_LIFE))
    again = Checkpoint(file, given["key"])
    there = again.resume() if file.exists() else 0
    if not done <= there <= done + 1:
        raise Wrong(f"{done} starts were kept, but {there} are there")


def _program(folder: Path, chance: random.Random) -> None:
    """Two that write the same program at once are killed: it is whole or not there."""
    from tp_jax import _stored

    class Program:
        def serialize(self) -> bytes:
            return b"x" * 300_000

    file = folder / "program"

    def keep(say: Callable[[int], None]) -> None:
        os.fork()
        for n in range(1, 10**6):
            _stored._keep(file, Program())  # type: ignore[arg-type]
            say(n)

    killed(keep, chance.uniform(0.0, LONGEST_LIFE))
    if file.exists() and len(file.read_bytes()) != _stored.BEGIN + 300_000:
        raise Wrong("half a program has its name")


def _entry(folder: Path, chance: random.Random) -> None:
    """A campaign.toml that is appended to keeps what the user wrote."""
    from tp_jax._files import replaced
    from tp_jax.recordings.sections import read_toml

    file = folder / "campaign.toml"
    file.write_text(corpus.CAMPAIGN)

    def append(say: Callable[[int], None]) -> None:
        for n in range(1, 10**6):
            text = file.read_text() + f'[[recording]]\nfile = "{n}.csv"\nforced = false\n'
            with replaced(file) as part:
                part.write_text(text)
            say(n)

    done = killed(append, chance.uniform(0.0, LONGEST_LIFE))
    read_toml(file)
    text = file.read_text()
    if not text.startswith(corpus.CAMPAIGN) or not done <= text.count("forced = false") - 1:
        raise Wrong("what was in campaign.toml is not there any more")


def _result(folder: Path, chance: random.Random) -> None:
    """A result that is replaced is the old or the new one."""
    from tp_jax.cli.output import write_json

    file = folder / "result.json"

    def write(say: Callable[[int], None]) -> None:
        for n in range(1, 10**6):
            write_json(file, {"n": n, "filling": [float(n)] * 3000})
            say(n)

    done = killed(write, chance.uniform(0.0, LONGEST_LIFE))
    if file.exists():
        content = json.loads(file.read_text())
        if not done <= content["n"] <= done + 1 or content["filling"] != [content["n"]] * 3000:
            raise Wrong("a result is not as it was written")
    elif done:
        raise Wrong("a result is gone")


def _trial(folder: Path, chance: random.Random) -> None:
    """A trial that is cut off again and again is the same in the end as one that is not."""
    from unittest import mock

    from tp_jax._files import replaced
    from trials import make as made

    def case_of(part: Path, case, _) -> dict:
        file = part / "sealed" / case.name / "key.json"
        file.parent.mkdir(parents=True, exist_ok=True)
        entry = corpus.part_of_key() | {"case": case.name}
        with replaced(file) as new:
            new.write_text(json.dumps(entry))
        return entry

    def whole(root: Path) -> str:
        with mock.patch("trials.make.make_case", case_of):
            return made(root, 5, 1)

    wanted = whole(folder / "unbroken")
    cut = folder / "cut"
    for _ in range(3):
        if not cut.exists():
            killed(lambda say: say(len(whole(cut))), chance.uniform(0.0, 0.03))
    if not cut.exists() and whole(cut) != wanted:
        raise Wrong("the trial is another")
    left = [p.name for p in folder.iterdir() if p.name not in ("unbroken", "cut")]
    if left or not (cut / "sealed" / "key.json").is_file() or list(cut.rglob("trial.json")):
        raise Wrong(f"the trial is not whole, or more than it is there: {left}")


def _recording(folder: Path, chance: random.Random) -> None:
    """Rows that were written stay, whole; the metadata say that it was cut off."""
    from tp_jax.recordings import load_campaign

    campaign = corpus.Folder(folder).made().root / "rig"
    before = (campaign / "campaign.toml").read_text()
    words = [
        sys.executable,
        "-m",
        "tp_jax",
        "record",
        "--port",
        "emulator",
        "--duration",
        "30",
        "--campaign",
        str(campaign),
        "--omega",
        "9",
        "--quiet",
    ]
    process = subprocess.Popen(words, stderr=subprocess.DEVNULL, start_new_session=True)
    time.sleep(chance.uniform(0.3, 5.0))
    process.kill()
    process.wait()
    if (campaign / "campaign.toml").read_text() != before:
        raise Wrong("campaign.toml is not what it was")
    file = campaign / "run-9.csv"
    if not file.exists():
        return
    text = file.read_text()
    rows = text.split("\n")[1:-1]
    if any(row.count(",") != 2 for row in rows):
        raise Wrong("a row is not whole")
    meta = json.loads((campaign / "run-9.csv.meta.json").read_text())
    if meta["state"] != "recording":
        raise Wrong(f"the metadata say {meta['state']}")
    if len(rows) > 1000:  # with a motion to speak of
        load_campaign(file, omega=9.0)
