"""Imports run one way only, and `import tp_jax` costs nothing."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PACKAGE = ROOT / "tp_jax"
TRIALS = ROOT / "trials"

# Layer -> the layers it may import, besides itself and EVERYWHERE. The root, tp_jax itself, is
# for the command line alone: its lazy names reach everywhere.
EVERYWHERE = {"errors", "_digits", "_files", "_float64", "_tails", "_version", "schemas"}
ALLOWED: dict[str, set[str]] = {
    "errors": set(),
    "_digits": set(),
    "_files": set(),
    "_float64": set(),
    "_blas": set(),
    "_memory": set(),
    "_tails": set(),
    "_version": set(),
    "_processor": set(),
    "_cache": set(),
    "_compiling": set(),
    "_compiler": {"_processor"},
    "_config": {"_cache", "_compiler", "_processor"},
    "_stored": {"_compiler", "_compiling", "_config", "_memory", "_processor"},
    "executors": {"_config"},
    "schemas": set(),
    "results": set(),
    "model": set(),
    "effects": {"model"},
    "simulation": {"_compiler", "model", "effects"},
    "recordings": set(),
    "checks": {"recordings"},
    "acquisition": {"recordings"},
    "estimation": {"_blas", "_stored", "model", "effects", "simulation", "recordings", "results"},
    "identifiability": {"model", "effects", "simulation", "recordings", "estimation"},
    # its simulator is to be independent of the model it puts to the test
    "rig": {"recordings", "acquisition"},
    "report": {
        "model",
        "effects",
        "simulation",
        "recordings",
        "checks",
        "estimation",
        "results",
    },
    "exploring": {"acquisition", "gap"},
    "serve": {"recordings", "checks", "report", "results"},
}
for each in ("gap", "sensitivity_analysis"):
    ALLOWED[each] = {"_blas", "identifiability", "estimation", *ALLOWED["identifiability"]}
    ALLOWED[each] |= {"report", "results"}
ALLOWED["cli"] = {"root", *ALLOWED}
ALLOWED["__main__"] = {"cli"}
ALLOWED["root"] = {*ALLOWED} - {"cli", "__main__"}
# beside the package, in the repository alone
ALLOWED["trials"] = {"effects", "executors", "recordings", "estimation", "gap", "results", "rig"}
BESIDE = {"trials", "scripts", "tests"}

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
    "results": {*JAX, "numpy", "scipy"},
    "executors": {*JAX, "numpy", "scipy"},
    # simulators of different make
    "rig": JAX,
    # a page that waits for a diagnosis in another process takes no memory for one
    "serve": JAX,
}

# What may be imported inside a function, besides the package itself in `cli` and the root, which
# answer at once and load what a command needs when it runs.
#: Not there on every machine: extras of the package, and what some systems lack.
OPTIONAL = {
    "openpyxl",
    "h5py",
    "pyarrow",
    "nptdms",
    "mcap",
    "mcap_ros2",
    "pandas",
    "zstandard",
    "compression",
    "tty",
    "serial.tools.list_ports",
    "starlette",
    "uvicorn",
    "arviz",
    "arviz_base",
    "tp_jax.serve.server",
    "ray",
    "dask",
    "distributed",
    "submitit",
}
#: JAX, whose settings come before it is loaded, and what is built on it.
WITH_JAX = {
    "jax",
    "diffrax",
    "tp_jax.simulation.rodas4",
    "tp_jax.simulation.reversal_controller",
}
#: Keeps and loads compiled programs, and computes nothing itself.
KEEPS_PROGRAMS = {"tp_jax._stored"}
#: Slow to load, and of use to one step of a program only.
SLOW = {"webbrowser", "scipy", "matplotlib", "rich", "jinja2", "markupsafe", "SALib", "jsonschema"}

DATA = {"examples"}
MODULES = [
    *sorted(p for p in PACKAGE.rglob("*.py") if p.relative_to(PACKAGE).parts[0] not in DATA),
    *sorted(TRIALS.rglob("*.py")),
]


def dotted(path: Path) -> list[str]:
    parts = list(path.relative_to(ROOT).with_suffix("").parts)
    return parts[:-1] if parts[-1] == "__init__" else parts


def layer(module: list[str]) -> str:
    if module[0] == "trials":
        return "trials"
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


def inside_functions(path: Path, text: str) -> list[str]:
    """What a file imports inside functions and may not."""
    own = layer(dotted(path))
    allowed = [*OPTIONAL, *WITH_JAX, *SLOW]
    if own in ("cli", "root"):
        allowed += ["tp_jax", "numpy"]
    said = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and any(
            isinstance(within, ast.Import | ast.ImportFrom) for within in ast.walk(node)
        ):
            for module in imported(path, ast.unparse(node)):
                name = ".".join(module)
                if not any(name == each or name.startswith(f"{each}.") for each in allowed):
                    said.append(f"{name} is imported in {node.name}(); import it at the top")
    return said


def circles(imports: dict[str, set[str]]) -> set[str]:
    """The modules that import one another, or lie between those that do."""
    left = {name: targets & set(imports) for name, targets in imports.items()}
    while True:
        wanted = set().union(*left.values())
        ends = {name for name, targets in left.items() if not targets or name not in wanted}
        if not ends:
            return set(left)
        left = {name: targets - ends for name, targets in left.items() if name not in ends}


def modules_imported(path: Path, text: str, known: set[str]) -> set[str]:
    """Names of the modules of the package and of trials that a file imports, anywhere in it."""
    own, found = dotted(path), set()
    package = own if path.name == "__init__.py" else own[:-1]
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            before = package[: len(package) - node.level + 1] if node.level else []
            base = ".".join([*before, *filter(None, [node.module])])
            names = {f"{base}.{alias.name}" for alias in node.names}
            found |= (names & known) | ({base} if names - known else set())
    return (found & known) - {".".join(own)}


def faults(path: Path, text: str) -> list[str]:
    own = layer(dotted(path))
    said = []
    for module in imported(path, text):
        if module[0] in BESIDE - {own}:
            said.append(f"{own} must not import {'.'.join(module)}")
        elif module[0] == "tp_jax":
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


@pytest.mark.parametrize("path", MODULES, ids=lambda path: ".".join(dotted(path)))
def test_imports_stand_at_the_top(path):
    assert inside_functions(path, path.read_text(encoding="utf-8")) == []


def test_no_module_imports_itself_by_way_of_others():
    names = {".".join(dotted(path)): path for path in MODULES}
    imports = {
        name: modules_imported(path, path.read_text(encoding="utf-8"), set(names))
        for name, path in names.items()
    }
    assert sum(map(len, imports.values())) > 1000
    assert circles(imports) == set()


def test_a_circle_is_seen():
    assert circles({"a": {"b"}, "b": {"c"}, "c": set()}) == set()
    assert circles({"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": {"a"}}) == {"b", "c"}
    known = {"tp_jax.gap", "tp_jax.gap.a", "tp_jax.gap.b"}
    for text in ("from tp_jax.gap import b", "from . import b", "def f():\n    from .b import x"):
        assert modules_imported(PACKAGE / "gap" / "a.py", text, known) == {"tp_jax.gap.b"}


@pytest.mark.parametrize(
    ("file", "text", "right"),
    [
        ("gap/a.py", "def f():\n    from tp_jax.gap import b", False),
        ("gap/a.py", "class A:\n    def f(self):\n        import json", False),
        ("recordings/a.py", "def f():\n    import numpy as np", False),
        ("recordings/a.py", "def f():\n    from pandas import DataFrame", True),
        ("cli/a.py", "def f():\n    import tp_jax as tp", True),
        ("cli/a.py", "def f():\n    import json", False),
        ("report/a.py", "def f():\n    import matplotlib.figure", True),
    ],
)
def test_an_import_inside_a_function_is_seen(file, text, right):
    assert (inside_functions(PACKAGE / file, text) == []) == right


@pytest.mark.parametrize(
    ("file", "text"),
    [
        ("model/a.py", "from tp_jax.effects import base"),
        ("model/a.py", "def f():\n    import tp_jax.simulation.solve"),
        ("effects/a.py", "from tp_jax import simulation"),
        ("gap/a.py", "import tp_jax as tp"),
        ("gap/a.py", "from tp_jax import simulate"),
        ("gap/__init__.py", "from ..cli import main"),
        ("gap/a.py", "from ..cli.output import write_json"),
        ("report/a.py", "from ..gap.diagnosis import Diagnosis"),
        ("recordings/a.py", "import jax.numpy as jnp"),
        ("acquisition/a.py", "from diffrax import diffeqsolve"),
        ("rig/a.py", "from trials.effects import base"),
        ("cli/a.py", "def f():\n    import trials"),
        ("../trials/a.py", "from tp_jax.cli import main"),
        ("../trials/a.py", "from scripts import _blind"),
    ],
)
def test_a_wrong_import_is_seen(file, text):
    assert len(faults((PACKAGE / file).resolve(), text)) == 1


@pytest.mark.parametrize(
    ("file", "text"),
    [
        ("effects/a.py", "from tp_jax.model.motion import Motion"),
        ("effects/a.py", "from .base import Effect\nfrom ..errors import InputError"),
        ("effects/__init__.py", "from . import base"),
        ("cli/a.py", "import tp_jax as tp"),
        ("recordings/a.py", "import numpy as np"),
        ("../trials/a.py", "from tp_jax.rig import VirtualRig\nfrom trials.effects import base"),
    ],
)
def test_a_right_import_is_let_through(file, text):
    assert faults((PACKAGE / file).resolve(), text) == []


def loaded_after(statement: str) -> set[str]:
    """Top-level names of all modules loaded after a statement in a fresh interpreter."""
    code = f"{statement}\nimport sys\nprint(*{{name.split('.')[0] for name in sys.modules}})"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=PACKAGE.parent
    )
    return set(done.stdout.split())


def test_importing_the_package_loads_nothing_heavy():
    assert loaded_after("import tp_jax").isdisjoint({*JAX, "numpy", "scipy", "rich", "matplotlib"})


def test_the_page_loads_nothing_heavy():
    pytest.importorskip("starlette", reason="needs the extra `serve`: pip install '.[serve]'")
    loaded = loaded_after("import tp_jax.serve.server")
    assert loaded.isdisjoint({*JAX, "scipy", "matplotlib"})


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


@pytest.fixture(scope="module")
def graph():
    """Module -> modules of the package that importing it loads directly, its packages included."""
    texts = {".".join(dotted(path)): (path, path.read_text("utf-8")) for path in MODULES}
    found = {}
    for name, (path, text) in texts.items():
        parents = {name.rsplit(".", k)[0] for k in range(1, name.count(".") + 1)}
        # what is imported at the top, outside `if TYPE_CHECKING:` and functions
        tree = ast.parse(text)
        tree.body = [node for node in tree.body if isinstance(node, ast.Import | ast.ImportFrom)]
        found[name] = modules_imported(path, ast.unparse(tree), set(texts)) | parents
    return found


def loads(name, graph):
    """All modules of the package that importing this one loads."""
    seen, ahead = set(), [name]
    while ahead:
        each = ahead.pop()
        if each not in seen:
            seen.add(each)
            ahead += graph[each]
    return seen


@pytest.mark.parametrize("path", MODULES, ids=lambda p: ".".join(dotted(p)))
def test_whatever_computes_with_jax_sets_64_bits(path, graph):
    """By whatever way a module is reached: 32 bits are never what it computes with."""
    tree = ast.parse(path.read_text("utf-8"))
    top = [node for node in tree.body if isinstance(node, ast.Import | ast.ImportFrom)]
    module = ast.unparse(ast.Module(body=top, type_ignores=[]))
    with_jax = any(name[0] in JAX for name in imported(path, module))
    name = ".".join(dotted(path))
    if with_jax and name not in KEEPS_PROGRAMS:
        assert "tp_jax._float64" in loads(name, graph)


@pytest.mark.parametrize("room", ["model.pendulum", "simulation", "estimation.identify", "gap"])
def test_a_room_imported_alone_computes_in_64_bits(room):
    code = f"import tp_jax.{room}, jax.numpy as jnp; assert jnp.zeros(1).dtype == 'float64'"
    subprocess.run([sys.executable, "-c", code], check=True, cwd=PACKAGE.parent)


def test_all_names_are_there():
    import tp_jax

    assert set(tp_jax.__all__) <= set(dir(tp_jax))
    assert set(tp_jax.__all__) - {"__version__"} == {*tp_jax._WITH_JAX, *tp_jax._WITHOUT_JAX}
    for name in tp_jax.__all__:
        assert getattr(tp_jax, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        tp_jax.nothing  # noqa: B018
