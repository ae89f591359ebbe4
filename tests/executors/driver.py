"""A study in a process of its own, which tests kill: `-m tests.executors.driver FOLDER N`."""

import sys
from pathlib import Path

from tests.executors.stand_in import some_pieces, summed
from tp_jax.executors import ExecutorChoice, run_pieces

if __name__ == "__main__":
    folder, count = Path(sys.argv[1]), int(sys.argv[2])
    asked = some_pieces(count, folder / "begun")
    for ended in run_pieces(
        summed, asked, ExecutorChoice("local", 2), folder=folder, uses_jax=False
    ):
        print(ended.piece.key, ended.kept, flush=True)
