"""Digest of all that a diagnosis computes: trials of one digest are of one program.

A comment, a docstring, the type of an argument, a page or a command change no verdict. A trial of
hundreds of rigs takes days, and would begin anew for each of them if every byte of the package
counted.
"""

import ast
import hashlib
from collections.abc import Collection, Iterator
from pathlib import Path

from tp_jax.errors import InputError

PACKAGE = Path(__file__).parent.parent / "tp_jax"

DIGITS = 12
"""Hexadecimal digits of a version that are written and shown."""

APART = (
    "acquisition",
    "checks",
    "cli",
    "examples",
    "executors",
    "exploring",
    "report",
    "results/sensitivity.py",
    "sensitivity_analysis",
    "serve",
)
"""Rooms, and a file, in which no number of a diagnosis, nor of a rig it is tried on, is made."""


def computed(package: Path = PACKAGE, apart: Collection[str] = APART) -> str:
    """Digest of what a diagnosis computes: the bare code of the package's rooms but for `apart`."""
    digest = hashlib.sha256()
    for file in files(package, apart):
        name = file.relative_to(package).as_posix()
        code = ast.dump(_bare(ast.parse(file.read_text(encoding="utf-8"))))
        digest.update(f"{name}\0{code}\0".encode())
    return digest.hexdigest()


def unchanged(version: str, package: Path = PACKAGE, apart: Collection[str] = APART) -> None:
    """Sees that the package is still of a version: a trial's worker imports it after the start.

    Raises:
        InputError: it is not.
    """
    if not computed(package, apart).startswith(version):
        raise InputError(
            f"The package is not of version {version}; run the same command again, without "
            "--version."
        )


def files(package: Path = PACKAGE, apart: Collection[str] = APART) -> Iterator[Path]:
    """Those files, in the order of their names."""
    for file in sorted(package.rglob("*.py")):
        place = file.relative_to(package)
        if place.parts[0] not in apart and place.as_posix() not in apart:
            yield file


def _bare(tree: ast.Module) -> ast.Module:
    """The same code without docstrings, strings that describe an attribute, and types of
    arguments."""
    for node in ast.walk(tree):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            node.returns = None
        if isinstance(node, ast.arg):
            node.annotation = None
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)):
            node.body = [line for line in node.body if not _is_text(line)] or [ast.Pass()]
    return tree


def _is_text(line: ast.stmt) -> bool:
    return (
        isinstance(line, ast.Expr)
        and isinstance(line.value, ast.Constant)
        and isinstance(line.value.value, str)
    )
