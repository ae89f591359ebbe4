"""Every notebook runs from its first cell to its last, and is kept with light outputs."""

import json
import re
from pathlib import Path

import pytest

from tests import kept

NOTEBOOKS = sorted((Path(__file__).parent.parent / "notebooks").glob("*.ipynb"))
TIMEOUT = 900  # seconds for a cell, on a busy machine
MOST_BYTES = 500_000
REMAKE = "run ./scripts/docs notebooks"
SKIPPED = "Skipped:"  # begins what a notebook prints that lacks its data

# Found by `tp-jax diagnose --json` of the wheel's campaign with seed 0: minutes that scripts/guard
# takes, which compares what is found today; without its curves, since the data are not ours.
WHEEL = Path(__file__).parent / "golden" / "pohl_wheel.json"

# What the notebook's own cells find, without its curves and residuals.
ROUGH = WHEEL.with_name("rough_bearing.json")

# a folder of somebody's machine, the address of an object, a terminal's colours
_PRIVATE = re.compile(r"/(home|root|tmp|work|Users)/|0x[0-9a-f]{8,}|\x1b\[")

# A notebook shows what takes a minute or three; that each of its lines runs is seen with less.
SMALLER = {
    "do_gradients_help": {
        "STARTS = 64": "STARTS = 2",
        "np.arange(1201)": "np.arange(301)",
        "iterations=400": "iterations=5",
        "max_steps=60": "max_steps=3",
        "COMPILING = 2": "COMPILING = 1",
        "repeats=20": "repeats=2",
        "np.linspace(-0.1, 1.0, 45)": "np.linspace(-0.1, 1.0, 5)",
    },
    "from_how_far_away": {
        "runs=4, duration=6.0": "runs=2, duration=2.0",
        "starts=17": "starts=3",
        "np.arange(1, 17)": "np.arange(1, 3)",
    },
    "what_can_these_recordings_tell": {
        "runs=4, duration=6.0": "runs=3, duration=2.0",
        'profile=("Ts1", "T0")': 'profile=("k",)',
    },
}


def diagnosed(name: str, request: pytest.FixtureRequest) -> dict | None:
    """What the notebook's diagnosis finds: other tests need the same, or it is kept."""
    if name == "diagnosing_a_gap":
        return kept.recorded().to_dict()
    if name == "your_own_effect":
        return kept.own_effect().to_dict()
    if name == "a_real_torsion_pendulum":
        request.getfixturevalue("shared")  # it reads the recording
        return json.loads(WHEEL.read_text(encoding="utf-8"))
    if name == "a_law_nobody_wrote_down":
        return json.loads(ROUGH.read_text(encoding="utf-8"))
    return None


def made_light(notebook, name: str, diagnosis: dict | None, folder: Path) -> None:
    """Smaller sizes, and the diagnosis in place of finding it."""
    for old, new in SMALLER.get(name, {}).items():
        holding = [cell for cell in notebook.cells if old in cell.source]
        assert holding, f"{name} has no longer {old!r}: see SMALLER"
        for cell in holding:
            cell.source = cell.source.replace(old, new)
    if diagnosis is not None:
        file = folder / "diagnosis.json"
        file.write_text(json.dumps(diagnosis), encoding="utf-8")
        first = next(cell for cell in notebook.cells if cell.cell_type == "code")
        first.source = (
            "import tp_jax\n"
            f"_kept = tp_jax.Diagnosis.from_json({str(file)!r})\n"
            "tp_jax.diagnose = lambda campaign, **options: _kept\n"
        ) + first.source


def stored(path: Path) -> list[dict]:
    return json.loads(path.read_text(encoding="utf-8"))["cells"]


def outputs(cells: list[dict]) -> list[dict]:
    return [output for cell in cells for output in cell.get("outputs", [])]


def said(output: dict) -> str:
    text = output.get("text", output.get("data", {}).get("text/plain", ""))
    return "".join(text)


def test_there_are_notebooks():
    assert NOTEBOOKS


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_is_kept_light(path):
    assert path.stat().st_size < MOST_BYTES, f"{REMAKE}, with smaller pictures"
    for cell in stored(path):
        assert cell.get("execution_count") is None, REMAKE
        assert cell["metadata"] == {}, REMAKE
    for output in outputs(stored(path)):
        assert output["output_type"] in ("stream", "display_data", "execute_result")
        assert output.get("name", "stdout") == "stdout", "a notebook is kept without warnings"
        assert output.get("execution_count") is None, REMAKE
        assert not _PRIVATE.search(said(output))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_has_a_title_and_is_kept_with_a_picture_at_its_end(path):
    cells = stored(path)
    title = "".join(cells[0]["source"]).splitlines()[0]
    assert cells[0]["cell_type"] == "markdown"
    assert title.startswith("# ")
    assert any("image/png" in o.get("data", {}) for o in cells[-1].get("outputs", [])), REMAKE


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_every_figure_is_kept_as_a_picture(path):
    figures = [o for o in outputs(stored(path)) if said(o).startswith("<Figure size")]
    assert all("image/png" in o["data"] for o in figures), REMAKE


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_runs_and_ends_in_a_picture(path, tmp_path, monkeypatch, request):
    reason = "running notebooks needs the extra `notebooks`: pip install '.[notebooks]'"
    nbclient = pytest.importorskip("nbclient", reason=reason)
    pytest.importorskip("ipykernel", reason=reason)
    pytest.importorskip("matplotlib", reason=reason)
    import nbformat

    for name in ("IPYTHONDIR", "JUPYTER_RUNTIME_DIR", "JUPYTER_DATA_DIR"):
        monkeypatch.setenv(name, str(tmp_path / name.lower()))
    work = tmp_path / "work"
    work.mkdir()
    notebook = nbformat.read(path, as_version=4)
    made_light(notebook, path.stem, diagnosed(path.stem, request), tmp_path)
    nbclient.NotebookClient(
        notebook, timeout=TIMEOUT, kernel_name="python3", resources={"metadata": {"path": work}}
    ).execute()

    assert list(work.iterdir()) == []
    skipped = [o for o in outputs(notebook.cells) if said(o).startswith(SKIPPED)]
    if skipped:
        pytest.skip(said(skipped[0]).strip())
    shown = [set(output.get("data", ())) for output in notebook.cells[-1].outputs]
    assert any("image/png" in kinds for kinds in shown)
    # what is kept shows as much as what runs
    pictures = ["image/png" in o.get("data", {}) for o in outputs(notebook.cells)]
    before = ["image/png" in o.get("data", {}) for o in outputs(stored(path))]
    assert sum(before) == sum(pictures), REMAKE
