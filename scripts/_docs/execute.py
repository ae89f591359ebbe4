"""Runs notebooks and keeps them with their outputs, light: no metadata, no counts, small pictures.

    ./scripts/docs notebooks [NAME ...]     all of them, or those named

A notebook that skips itself, since its data is not there, is left as it was.
"""

import base64
import io
import os
import sys
import tempfile
from pathlib import Path

import nbformat
from nbclient import NotebookClient
from PIL import Image

FOLDER = Path(__file__).parent.parent.parent / "notebooks"
COLOURS = 160
TIMEOUT = 900  # s for a cell
NOT_HERE = "Skipped:"  # begins what a notebook prints that lacks its data


def main(names: list[str]) -> None:
    os.environ.setdefault("EQX_ON_ERROR", "nan")
    for path in sorted(FOLDER.glob("*.ipynb")):
        if not names or path.stem in names:
            print(path.name, flush=True)
            execute(path)


def execute(path: Path) -> None:
    """Runs one notebook in an empty folder, beside which it finds what the repository has."""
    notebook = nbformat.read(path, as_version=4)
    with tempfile.TemporaryDirectory() as work:
        NotebookClient(
            notebook,
            timeout=TIMEOUT,
            kernel_name="python3",
            resources={"metadata": {"path": work}},
        ).execute()
    if any(said.startswith(NOT_HERE) for said in texts(notebook)):
        print(f"  {path.name} lacks its data and is left as it was")
        return
    lighten(notebook)
    nbformat.write(notebook, path)


def texts(notebook: nbformat.NotebookNode) -> list[str]:
    """Returns what a notebook's cells print."""
    outputs = [o for cell in notebook.cells for o in cell.get("outputs", [])]
    return ["".join(o["text"]) for o in outputs if o["output_type"] == "stream"]


def lighten(notebook: nbformat.NotebookNode) -> None:
    """Takes out what differs from run to run and says nothing."""
    notebook.metadata = {"kernelspec": {"display_name": "Python 3", "name": "python3"}}
    for cell in notebook.cells:
        cell.metadata = {}
        if cell.cell_type != "code":
            continue
        cell.execution_count = None
        # XLA says on a busy machine that it compiles slowly
        cell.outputs = [o for o in cell.outputs if "slow_operation_alarm" not in o.get("text", "")]
        for output in cell.outputs:
            if "execution_count" in output:
                output.execution_count = None
            if "data" in output:
                output.metadata = {}
                if "image/png" in output.data:
                    output.data = {"image/png": smaller(output.data["image/png"])}


def smaller(png: str) -> str:
    """A picture in base64, on white, with few colours: a drawing takes a third of its size then."""
    picture = Image.open(io.BytesIO(base64.b64decode(png))).convert("RGBA")
    white = Image.new("RGBA", picture.size, "white")
    few = io.BytesIO()
    white = Image.alpha_composite(white, picture).convert("RGB")
    white.quantize(COLOURS, dither=Image.Dither.NONE).save(few, "png", optimize=True)
    return base64.b64encode(few.getvalue()).decode("ascii")


if __name__ == "__main__":
    main(sys.argv[1:])
