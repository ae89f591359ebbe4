"""Searches killed at random moments and gone on with: the result is that of one that was not."""

import json
import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from scripts._attack.tally import Tally, Wrong

CAMPAIGN = Path(__file__).parents[2] / "tp_jax" / "examples" / "case-02"

LONGEST = 600
"""Seconds; the first search compiles."""


def attack(tally: Tally, searches: int, seed: int = 0) -> None:
    """Makes so many searches, each killed twice."""
    if not searches:
        return
    chance = random.Random(seed)
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        _run(_words(root, "whole"), LONGEST)
        begun = time.monotonic()
        _run(_words(root, "whole"), LONGEST)  # nothing is compiled any more
        took = time.monotonic() - begun
        for i in range(searches):
            tally.attempt(
                "kill: search",
                lambda i=i: _search(root, f"cut{i}", took, chance),
                f"no. {i}",
                3 * LONGEST,
            )


def _search(root: Path, name: str, took: float, chance: random.Random) -> None:
    """Killed twice, then let to its end."""
    starts = root / name / "starts.json"
    for _ in range(2):
        _run(_words(root, name, resume=starts.exists()), chance.uniform(0.3, 0.9) * took)
    _run(_words(root, name, resume=starts.exists()), LONGEST)
    results = [json.loads((root / f"{n}.json").read_text()) for n in ("whole", name)]
    for each in results:
        del each["provenance"]["wall_s"]
    if results[0] != results[1]:
        raise Wrong("the result differs from that of a search that was not killed")


def _words(root: Path, name: str, *, resume: bool = False) -> list[str]:
    words = ["identify", str(CAMPAIGN), "--starts", "6", "--quiet"]
    words += ["--out", str(root / name), "--json", str(root / f"{name}.json")]
    return [sys.executable, "-m", "tp_jax", *words, *(["--resume"] if resume else [])]


def _run(words: list[str], life: float) -> None:
    """Lets it run, and kills it after so many seconds."""
    process = subprocess.Popen(words, stderr=subprocess.PIPE, text=True)
    try:
        _, said = process.communicate(timeout=life)
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()
        return
    if process.returncode:
        raise Wrong(f"exit code {process.returncode}: {said[-200:]}")
