"""A trial's version: what a diagnosis computes, and nothing else."""

import ast

import pytest

from scripts._version import APART, PACKAGE, computed, files, unchanged
from tp_jax.errors import InputError

CODE = '''"""A page."""

A = 1.0
"""Its reason."""


def twice(x):
    """Returns twice as much."""
    return A * x  # said once more
'''


def made(folder, code, **others):
    (folder / "gap").mkdir(parents=True)
    (folder / "gap" / "one.py").write_text(code)
    for room, text in others.items():
        (folder / room).mkdir()
        (folder / room / "other.py").write_text(text)
    return computed(folder)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("A page.", "Another."),
        ("Its reason.", "Another."),
        ("Returns twice", "Gives twice"),
        ("  # said once more", ""),
        ("(x):", "(x: float) -> float:"),
        ("A * x", "(A\n        * x)"),
    ],
)
def test_words_and_layout_do_not_count(tmp_path, old, new):
    assert old in CODE
    assert made(tmp_path / "a", CODE) == made(tmp_path / "b", CODE.replace(old, new))


def test_a_docstring_alone_is_a_body_all_the_same(tmp_path):
    made(tmp_path / "a", 'def nothing():\n    """Does nothing."""\n')


def test_code_counts(tmp_path):
    assert made(tmp_path / "a", CODE) != made(tmp_path / "b", CODE.replace("1.0", "2.0"))


def test_a_package_that_changes_meanwhile_is_told(tmp_path):
    version = made(tmp_path / "a", CODE)[:12]
    unchanged(version, tmp_path / "a")
    (tmp_path / "a" / "gap" / "one.py").write_text("A = 2.0\n")
    with pytest.raises(InputError, match=version):
        unchanged(version, tmp_path / "a")


def test_rooms_apart_do_not_count_and_others_do(tmp_path):
    alone = made(tmp_path / "a", CODE)
    assert made(tmp_path / "b", CODE, cli="B = 1\n", report="C = 1\n") == alone
    assert made(tmp_path / "c", CODE, model="B = 1\n") != alone


def test_rooms_apart_exist_and_nothing_that_computes_reads_them():
    """But for a diagnosis, which writes its report, and a rig that speaks to a recorder."""
    apart = {("gap/diagnosis.py", "report"), ("rig/emulator.py", "acquisition")}
    assert all((PACKAGE / room).exists() for room in APART)
    for file in files():
        place = file.relative_to(PACKAGE)
        if place.name in ("__init__.py", "__main__.py") and place.parent.name == "":
            continue  # the list of public names, and the command
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            for name in names:
                room = name.split(".")[1] if name.startswith("tp_jax.") else ""
                file = name.removeprefix("tp_jax.").replace(".", "/") + ".py"
                fine = (room not in APART and file not in APART) or (str(place), room) in apart
                assert fine, f"{place}: {name}"
