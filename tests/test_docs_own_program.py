"""The programs on the page `docs/own_program.md` run as they stand there."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PAGE = (ROOT / "docs" / "own_program.md").read_text(encoding="utf-8")
PROGRAMS = re.findall(r"^```python\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)


def test_there_are_programs():
    assert len(PROGRAMS) == 6


@pytest.mark.slow
@pytest.mark.parametrize("program", PROGRAMS, ids=range(len(PROGRAMS)))
def test_a_program_runs(program, tmp_path):
    made = tmp_path / "case-02-diagnosis" / "diagnosis.json"  # which one of them reads
    made.parent.mkdir()
    shutil.copy(ROOT / "tests" / "golden" / "rough_bearing.json", made)
    file = tmp_path / "program.py"  # workers of `spawn` import it anew
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


def test_its_loggers_are_those_of_the_package():
    rows = re.findall(r"^\| ((?:`[\w.]+`(?:, )?)+) \|", PAGE, re.MULTILINE)
    named = set()
    for row in rows:
        names = re.findall(r"`([\w.]+)`", row)
        if names[0].startswith("tp_jax."):
            folder = names[0].rpartition(".")[0]
            named |= {n if not n.startswith(".") else folder + n for n in names}
    logging = {
        ".".join(file.relative_to(ROOT).with_suffix("").parts)
        for file in (ROOT / "tp_jax").rglob("*.py")
        if "logging.getLogger(__name__)" in file.read_text(encoding="utf-8")
    }
    assert named == logging
