"""Every notebook runs from its first cell to its last, and is kept with light outputs."""

import json
import re
from pathlib import Path

import pytest

NOTEBOOKS = sorted((Path(__file__).parent.parent / "notebooks").glob("*.ipynb"))
TIMEOUT = 1500  # seconds for a cell; a diagnosis of the wheel shares its processors here
MOST_BYTES = 500_000
REMAKE = "run ./scripts/docs notebooks"
SKIPPED = "Skipped:"  # begins what a notebook prints that lacks its data

# a folder of somebody's machine, the address of an object, a terminal's colours
_PRIVATE = re.compile(r"/(home|root|tmp|work|Users)/|0x[0-9a-f]{8,}|\x1b\[")


def kept(path: Path) -> list[dict]:
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
    for cell in kept(path):
        assert cell.get("execution_count") is None, REMAKE
        assert cell["metadata"] == {}, REMAKE
    for output in outputs(kept(path)):
        assert output["output_type"] in ("stream", "display_data", "execute_result")
        assert output.get("name", "stdout") == "stdout", "a notebook is kept without warnings"
        assert output.get("execution_count") is None, REMAKE
        assert not _PRIVATE.search(said(output))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_has_a_title_and_is_kept_with_a_picture_at_its_end(path):
    cells = kept(path)
    title = "".join(cells[0]["source"]).splitlines()[0]
    assert cells[0]["cell_type"] == "markdown"
    assert title.startswith("# ")
    assert any("image/png" in o.get("data", {}) for o in cells[-1].get("outputs", [])), REMAKE


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_every_figure_is_kept_as_a_picture(path):
    figures = [o for o in outputs(kept(path)) if said(o).startswith("<Figure size")]
    assert all("image/png" in o["data"] for o in figures), REMAKE


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_runs_and_ends_in_a_picture(path, tmp_path, monkeypatch):
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
    stored = ["image/png" in o.get("data", {}) for o in outputs(kept(path))]
    assert sum(stored) == sum(pictures), REMAKE
