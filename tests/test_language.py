"""Docstrings say at once what a thing is or does: none opens with a clause for a subject.

And the formatter lays out the code, but for a few tables.
"""

import ast
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parent.parent
PACKAGE = ROOT / "tp_jax"

MOST_SKIPPED = 20
"""Places in all Python files that the formatter may be told to leave alone."""

ROOMS = (
    "",  # the files beside the folders
    "model",
    "effects",
    "simulation",
    "estimation",
    "identifiability",
    "sensitivity_analysis",
    "gap",
    "recordings",
    "checks",
    "acquisition",
    "rig",
    "cli",
    "serve",
    "executors",
    "exploring",
    "report",
    "results",
    "schemas",
)
"""Folders of the package, with what is in them, whose docstrings are looked at."""

HEADLESS = (
    "What",
    "That",
    "Whether",
    "Which",
    "Who",
    "Those",
    "Whose",
    "How",
    "Where",
    "When",
    "Why",
)


def files() -> Iterator[Path]:
    for room in ROOMS:
        found = (PACKAGE / room).rglob("*.py") if room else PACKAGE.glob("*.py")
        yield from sorted(found)


def headless(node: ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef) -> bool:
    """True where a docstring's first word is one of those."""
    words = (ast.get_docstring(node) or "").split(maxsplit=1)
    return bool(words) and words[0].strip("*`,.:;") in HEADLESS


def test_the_rooms_have_files():
    assert all(any((PACKAGE / room).glob("*.py")) for room in ROOMS)


def test_no_module_opens_with_a_clause():
    opened = [
        str(file.relative_to(PACKAGE))
        for file in files()
        if headless(ast.parse(file.read_text(encoding="utf-8")))
    ]
    assert opened == []


def test_no_function_or_class_opens_with_a_clause():
    kinds = (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    opened = [
        f"{file.relative_to(PACKAGE)}:{node.lineno} {node.name}"
        for file in files()
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, kinds) and headless(node)
    ]
    assert opened == []


def test_the_formatter_lays_out_the_code():
    mark = "# fmt" + ": "
    skipped = sum(
        file.read_text(encoding="utf-8").count(mark)
        for folder in ("tp_jax", "trials", "scripts", "tests")
        for file in (ROOT / folder).rglob("*.py")
    )
    assert skipped <= MOST_SKIPPED
