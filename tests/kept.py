"""Diagnoses that several tests look at: each is made once in a run of the tests, by whichever
process asks first."""

import fcntl
import json
import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tp_jax._files import replaced
from tp_jax.cli.output import json_text
from tp_jax.gap.diagnosis import Diagnosis

ROOT = Path(__file__).parent.parent
FOLDER = "TP_JAX_TESTS_KEPT"  # a variable of this run's processes; see conftest


def kept(name: str, find: Callable[[], dict[str, Any]]) -> Diagnosis:
    """The diagnosis of this name, as its JSON has it; found and kept if it is not there yet."""
    file = Path(os.environ[FOLDER], f"{name}.json")
    with file.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # another process may be at it
        if not file.is_file():
            text = json_text(find())
            with replaced(file) as part:
                part.write_text(text, encoding="utf-8")
    return Diagnosis.from_json(file)


HIDDEN = 0.5
"""The drop of the contact's friction in `recorded`, as the virtual rig has it."""


def recorded() -> Diagnosis:
    """Of what the virtual rig recorded: the example of docs/recording.md, by the real commands."""

    def find() -> dict[str, Any]:
        folder = recorded_folder()
        folder.parent.mkdir()
        for omega in ("6", "10", "13.09", "17", "22", None):
            run = ["--release", "0.6"] if omega is None else ["--omega", omega]
            _shell(
                folder.parent,
                "record",
                "--port",
                "emulator",
                "--duration",
                "4",
                "--rate",
                "250",
                *run,
                "--campaign",
                folder.name,
                "--effect",
                f"contact_stribeck={HIDDEN}",
                "--speed",
                "max",
            )
        return json.loads(_shell(folder.parent, "diagnose", folder.name, "--json", "-"))

    return kept("recorded", find)


def recorded_folder() -> Path:
    """Where the recordings of `recorded` are."""
    return Path(os.environ[FOLDER], "shell", "my-rig")


def _shell(cwd: Path, *args: str) -> str:
    done = subprocess.run(
        [sys.executable, "-m", "tp_jax", "--quiet", *args],
        cwd=cwd,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


_FILE = re.compile(r'^```python title="([^"]+)"\n(.*?)^```', re.DOTALL | re.MULTILINE)


def page_files() -> dict[str, str]:
    """The files that the page on adding an effect shows, by name, in its order."""
    page = ROOT / "docs" / "adding_an_effect.md"
    return dict(_FILE.findall(page.read_text(encoding="utf-8")))


FEW = {"sensor1_nonlinearity", "sensor2_nonlinearity", "sensor2_drift", "sensor_crosstalk"}
"""Of the catalogue, what `own_effect` weighs the page's effect against: effects of sensors need no
compiled program of the motion of their own. Which programs an effect from outside shares with those
of the catalogue is put to the test in estimation/test_program.py."""

_AMONG_FEW = """
import runpy, sys
from tp_jax.effects import registry
every = registry._built_in()
registry._built_in = lambda: {{id: every[id] for id in {few}}}
sys.path.insert(0, "")
diagnosis = runpy.run_path("diagnose.py", run_name="__main__")["diagnosis"]
from tp_jax.cli.output import json_text  # what the page leaves to the reader: to look at numbers
open("diagnosis.json", "w").write(json_text(diagnosis.to_dict()))
"""


def own_effect() -> Diagnosis:
    """Of the rig of that page, by its own files; what they print and write lies in `own_folder`."""

    def find() -> dict[str, Any]:
        folder = own_folder()
        folder.mkdir()
        for name, text in page_files().items():
            (folder / name).write_text(text, encoding="utf-8")
        environment = os.environ | {"PYTHONPATH": str(ROOT), "EQX_ON_ERROR": "nan"}
        for command in (["make_campaign.py"], ["-c", _AMONG_FEW.format(few=FEW)]):
            done = subprocess.run(
                [sys.executable, *command],
                cwd=folder,
                env=environment,
                capture_output=True,
                text=True,
            )
            assert done.returncode == 0, done.stderr
            (folder / "said.txt").write_text(done.stdout, encoding="utf-8")
        return json.loads((folder / "diagnosis.json").read_text(encoding="utf-8"))

    return kept("contact-spin", find)


def own_folder() -> Path:
    """Where `own_effect` was made."""
    return Path(os.environ[FOLDER], "own-effect")
