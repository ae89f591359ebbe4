"""Imports run one way only, and `import tp_jax` costs nothing."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parent.parent / "tp_jax"

# Layer -> the layers it may import, besides itself and EVERYWHERE. The root, tp_jax itself, is
# for the command line alone: its lazy names reach everywhere.
EVERYWHERE = {"errors", "_digits", "_files", "_tails", "_version", "schemas"}
ALLOWED: dict[str, set[str]] = {
    "errors": set(),
    "_digits": set(),
    "_files": set(),
    "_memory": set(),
    "_tails": set(),
    "_version": set(),
    "_processor": set(),
    "_cache": set(),
    "_compiler": {"_processor"},
    "_config": {"_cache", "_compiler", "_processor"},
    "_stored": {"_compiler", "_config", "_memory", "_processor"},
    "schemas": set(),
    "model": set(),
    "effects": {"model"},
    "simulation": {"_compiler", "model", "effects"},
    "recordings": set(),
    "checks": {"recordings"},
    "acquisition": {"recordings"},
    "estimation": {"_stored", "model", "effects", "simulation", "recordings"},
    "identifiability": {"model", "effects", "simulation", "recordings", "estimation"},
    "sensitivity_analysis": {
        "model",
        "effects",
        "simulation",
        "recordings",
        "estimation",
        "identifiability",
    },
    "validation": {
        "model",
        "effects",
        "simulation",
        "recordings",
        "estimation",
        "identifiability",
    },
    "gap": {"model", "effects", "simulation", "recordings", "estimation", "identifiability"},
    # its simulator is to be independent of the model it puts to the test
    "rig": {"recordings", "acquisition"},
    "report": {
        "model",
        "effects",
        "simulation",
        "recordings",
        "checks",
        "estimation",
        "gap",
    },
    "exploring": {"acquisition", "gap"},
    "blind": {"effects", "recordings", "estimation", "gap", "rig"},
}
ALLOWED["cli"] = {"root", *ALLOWED}
ALLOWED["__main__"] = {"cli"}
ALLOWED["root"] = {*ALLOWED} - {"cli", "__main__"}

JAX = {"jax", "jaxlib", "jaxtyping", "equinox", "diffrax", "optimistix", "lineax"}
FORBIDDEN = {
    "recordings": JAX,
    "acquisition": JAX,
    "checks": JAX,
    "errors": {*JAX, "numpy", "scipy"},
    "_files": {*JAX, "numpy", "scipy"},
    "_memory": {*JAX, "numpy", "scipy"},
    "_cache": {*JAX, "numpy", "scipy"},
    "_processor": {*JAX, "numpy", "scipy"},
    "schemas": {*JAX, "numpy", "scipy"},
    # simulators of different make
    "rig": JAX,
}

DATA = {"examples"}
MODULES = sorted(p for p in PACKAGE.rglob("*.py") if p.relative_to(PACKAGE).parts[0] not in DATA)


def dotted(path: Path) -> list[str]:
    parts = list(path.relative_to(PACKAGE.parent).with_suffix("").parts)
    return parts[:-1] if parts[-1] == "__init__" else parts


def layer(module: list[str]) -> str:
    return module[1] if len(module) > 1 else "root"


def imported(path: Path, text: str) -> list[list[str]]:
    """Every module that a file imports, anywhere in it, types included, as parts of its name."""
    package = dotted(path) if path.name == "__init__.py" else dotted(path)[:-1]
    found = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            found += [alias.name.split(".") for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = (node.module or "").split(".") if node.module else []
            if node.level:
                base = package[: len(package) - node.level + 1] + base
            # `from tp_jax import effects` names a module, `from tp_jax import simulate` the root
            names = [[*base, alias.name] for alias in node.names] if base == ["tp_jax"] else [base]
            found += [name if len(name) != 2 or name[1] in ALLOWED else base for name in names]
    return found


def faults(path: Path, text: str) -> list[str]:
    own = layer(dotted(path))
    said = []
    for module in imported(path, text):
        if module[0] == "tp_jax":
            target = layer(module)
            if target not in {own, *EVERYWHERE, *ALLOWED[own]}:
                said.append(f"{own} must not import {'.'.join(module)}")
        elif module[0] in FORBIDDEN.get(own, set()):
            said.append(f"{own} must do without {module[0]}")
    return said


def test_every_layer_is_listed():
    there = {layer(dotted(path)) for path in MODULES}
    assert there <= set(ALLOWED), "say in ALLOWED what the new part may import"


def test_layers_have_an_order():
    # one way only: repeatedly take away what imports nothing that is left
    left = {name: set(targets) - EVERYWHERE for name, targets in ALLOWED.items()}
    while left:
        free = {name for name, targets in left.items() if not targets & set(left)}
        assert free, f"these import one another: {sorted(left)}"
        left = {name: targets for name, targets in left.items() if name not in free}


@pytest.mark.parametrize("path", MODULES, ids=lambda path: ".".join(dotted(path)))
def test_imports_only_what_lies_below(path):
    assert faults(path, path.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize(
    ("file", "text"),
    [
        ("model/a.py", "from tp_jax.effects import base"),
        ("model/a.py", "def f():\n    import tp_jax.simulation.solve"),
        ("effects/a.py", "from tp_jax import simulation"),
        ("gap/a.py", "import tp_jax as tp"),
        ("gap/a.py", "from tp_jax import simulate"),
        ("gap/__init__.py", "from ..cli import main"),
        ("gap/a.py", "from ..report.html import write_report"),
        ("recordings/a.py", "import jax.numpy as jnp"),
        ("acquisition/a.py", "from diffrax import diffeqsolve"),
    ],
)
def test_a_wrong_import_is_seen(file, text):
    assert len(faults(PACKAGE / file, text)) == 1


@pytest.mark.parametrize(
    ("file", "text"),
    [
        ("effects/a.py", "from tp_jax.model.motion import Motion"),
        ("effects/a.py", "from .base import Effect\nfrom ..errors import InputError"),
        ("effects/__init__.py", "from . import base"),
        ("cli/a.py", "import tp_jax as tp"),
        ("recordings/a.py", "import numpy as np"),
    ],
)
def test_a_right_import_is_let_through(file, text):
    assert faults(PACKAGE / file, text) == []


def loaded_after(statement: str) -> set[str]:
    """Top-level names of all modules loaded after a statement in a fresh interpreter."""
    code = f"{statement}\nimport sys\nprint(*{{name.split('.')[0] for name in sys.modules}})"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=PACKAGE.parent
    )
    return set(done.stdout.split())


def test_importing_the_package_loads_nothing_heavy():
    assert loaded_after("import tp_jax").isdisjoint({*JAX, "numpy", "scipy", "rich", "matplotlib"})


@pytest.mark.parametrize("name", ["recordings", "acquisition", "checks"])
def test_loads_without_jax(name):
    if not (PACKAGE / name).is_dir():
        pytest.skip(f"there is no tp_jax.{name} yet")
    assert loaded_after(f"import tp_jax.{name}").isdisjoint(JAX)


def test_using_a_name_sets_64_bits():
    code = (
        "import tp_jax as tp; tp.presets; import jax.numpy as jnp; "
        "assert jnp.zeros(1).dtype == 'float64'"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=PACKAGE.parent)


def test_all_names_are_there():
    import tp_jax

    assert set(tp_jax.__all__) <= set(dir(tp_jax))
    assert set(tp_jax.__all__) - {"__version__"} == {*tp_jax._WITH_JAX, *tp_jax._WITHOUT_JAX}
    for name in tp_jax.__all__:
        assert getattr(tp_jax, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        tp_jax.nothing  # noqa: B018
