"""Annotations checked while tests run: a small part of what `-p tests.typechecker` is for."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent


@pytest.mark.slow
def test_the_model_and_the_results_are_what_their_annotations_say():
    options = ["-q", "-p", "tests.typechecker", "-p", "no:cacheprovider", "-m", "not slow"]
    done = subprocess.run(
        [sys.executable, "-m", "pytest", *options, "tests/model", "tests/results"],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout[-3000:]
