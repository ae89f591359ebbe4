"""The page on the architecture names files and functions that there are."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
STEPS = re.findall(r"^\| \w+ \| `(\w+)` \| `([\w/.]+\.py)` \|", PAGE, re.MULTILINE)
PATHS = sorted(set(re.findall(r"`((?:tp_jax|trials|tests)/[\w/.]*)`", PAGE)))


def defined(file: Path) -> set[str]:
    """Names of functions and classes at the top of a file."""
    nodes = ast.parse(file.read_text(encoding="utf-8")).body
    return {node.name for node in nodes if isinstance(node, ast.FunctionDef | ast.ClassDef)}


def test_there_are_steps_and_paths():
    assert len(STEPS) > 20
    assert len(PATHS) > 50


@pytest.mark.parametrize(("function", "file"), STEPS)
def test_a_step_is_where_the_page_says(function, file):
    assert function in defined(ROOT / file)


@pytest.mark.parametrize("path", PATHS)
def test_a_path_exists(path):
    assert (ROOT / path).exists()


def test_every_folder_of_the_package_has_a_row():
    folders = [f for f in (ROOT / "tp_jax").iterdir() if f.is_dir() and f.name != "__pycache__"]
    for folder in folders:
        assert f"\n| `tp_jax/{folder.name}/` |" in PAGE


def test_names_of_types_are_those_of_the_code():
    """What the tables call a type is a class of the package."""
    rows = [line.split("|") for line in PAGE.splitlines() if re.match(r"\| \w+ \| `", line)]
    named = {name for row in rows for name in re.findall(r"`([A-Z]\w+)`", "|".join(row[4:]))}
    classes = {name for file in (ROOT / "tp_jax").rglob("*.py") for name in defined(file)}
    assert len(named) > 10
    assert named <= classes
