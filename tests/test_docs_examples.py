"""Every example in a docstring runs, and says what it says it does."""

import ast
import doctest
import importlib
from pathlib import Path

import numpy as np
import pytest

import tp_jax as tp

PACKAGE = Path(tp.__file__).parent


def docstrings(path: Path) -> list[str]:
    """All docstrings of a file."""
    kinds = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    nodes = ast.walk(ast.parse(path.read_text(encoding="utf-8")))
    return [ast.get_docstring(node) or "" for node in nodes if isinstance(node, kinds)]


def modules_with_examples() -> list[str]:
    found = []
    for path in sorted(PACKAGE.rglob("*.py")):
        # parsing all files takes seconds of every process of a run
        shown = ">>>" in path.read_text(encoding="utf-8")
        if shown and any(">>>" in text for text in docstrings(path)):
            parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
            found.append(".".join(parts).removesuffix(".__init__"))
    return found


MODULES = modules_with_examples()


def test_there_are_examples():
    assert {"tp_jax.simulation.solve", "tp_jax.simulation.sweep"} <= set(MODULES)


@pytest.mark.parametrize("name", MODULES)
def test_examples_run(name):
    module = importlib.import_module(name)
    tests = doctest.DocTestFinder(exclude_empty=True).find(module, extraglobs={"np": np, "tp": tp})
    tests = [test for test in tests if test.examples]
    assert tests, "the examples are seen"
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    for test in tests:
        report: list[str] = []
        runner.run(test, out=report.append)
        assert not report, "".join(report)


def test_the_module_of_effects_shows_an_effect_that_works():
    """The example at the head of `tp_jax.effects.base` is an effect as it stands."""
    from tp_jax.effects import base

    lines = (base.__doc__ or "").splitlines()
    begin = next(i for i, line in enumerate(lines) if line.lstrip().startswith("class "))
    body = [line for line in lines[begin:] if line.startswith("    ") or not line]
    code = "\n".join(line[4:] for line in body)
    found: dict = {}
    exec(code, vars(base) | {"abs": abs}, found)
    (shown,) = found.values()
    real = tp.effects.get(shown.id)
    assert shown.location == real.location
    motion = base.Motion(k=2.0, d=-0.5)
    assert shown().increment(motion, 0.1) == pytest.approx(float(real.increment(motion, 0.1)))
