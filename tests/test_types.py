"""Types: pyright finds no more errors than the number that is kept here, which only falls."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent

#: Errors of `pyright` in basic mode over tp_jax/ and trials/.
MOST_ERRORS = 0


@pytest.mark.slow
def test_there_are_no_more_errors_of_types():
    pytest.importorskip("pyright", reason="it is in the extra `dev`: pip install '.[dev]'")
    if shutil.which("node") is None:
        pytest.skip("pyright runs on node, which is not there, and tests fetch nothing")
    done = subprocess.run(
        [sys.executable, "-m", "pyright", "--outputjson"], cwd=ROOT, capture_output=True, text=True
    )
    found = json.loads(done.stdout)["generalDiagnostics"]
    errors = [
        f"{Path(each['file']).relative_to(ROOT)}:{each['range']['start']['line'] + 1}: "
        f"{each['message'].splitlines()[0]}"
        for each in found
        if each["severity"] == "error"
    ]
    assert len(errors) <= MOST_ERRORS, "\n".join(errors)
