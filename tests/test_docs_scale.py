"""The page docs/scale.md: its program runs, its commands can be typed, its names are the code's."""

import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from tp_jax.cli import build_parser
from tp_jax.executors import KINDS
from tp_jax.executors.pieces import MOST_DEATHS
from tp_jax.gap.detectability import TIED
from tp_jax.gap.policy import POLICY

ROOT = Path(__file__).parent.parent
PAGE = (ROOT / "docs" / "scale.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_its_program_runs_and_keeps_its_pieces(tmp_path):
    (program,) = re.findall(r"^```python\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)
    file = tmp_path / "program.py"
    file.write_text(program, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, str(file)],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert done.returncode == 0, done.stderr
    kept = sorted((tmp_path / "study" / "pieces").glob("*.json"))
    peaks = {f.stem: json.loads(f.read_text())["result"]["peak"] for f in kept}
    assert {
        line.partition(" ")[0]: float(line.split()[1]) for line in done.stdout.splitlines()
    } == (peaks)
    assert len(peaks) == 3


def test_its_commands_can_be_typed():
    blocks = re.findall(r"^```sh\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)
    lines = "".join(blocks).replace("\\\n", " ").splitlines()
    for line in lines:
        words = shlex.split(line, comments=True)
        argv = words[words.index("tp-jax") + 1 :]
        assert build_parser().parse_args(argv).campaign
    assert len(lines) == 7


def test_it_has_a_row_for_each_executor():
    assert re.findall(r"^\| `(\w+)` \|", PAGE, re.MULTILINE) == list(KINDS)
    assert MOST_DEATHS == 5
    assert "five workers have died" in PAGE


def test_it_has_the_numbers_that_decide_what_rigs_share():
    shared, text = POLICY.shared, " ".join(PAGE.split())
    assert f"larger with probability below {shared.level:g}." in text
    assert f"does not reject at {shared.differ:g}, " in text
    assert f"({shared.near:g} nat of −log p)" in text
    assert f"(|cos| above {TIED:g})" in text
    assert f"(|cos| above {shared.alike:g})" in text
    assert shared.rigs == 3
    assert "at least three rigs" in text
    assert (shared.spread, shared.kept, shared.least) == (0.5, 0.5, 0.05)
    assert "less than half of the mean" in text
    assert "half of the reduction" in text
    assert "less than a twentieth" in text
