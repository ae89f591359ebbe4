"""Notebooks as pages, with the outputs they are stored with; nothing is run."""

import base64
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

_COLOURS = re.compile(r"\x1b\[[0-9;]*m")


class Page(NamedTuple):
    """A page, and the pictures that belong beside it by name."""

    name: str
    markdown: str
    pictures: dict[str, bytes]


def pages(folder: Path) -> list[Page]:
    """A page for each notebook in a folder, in alphabetical order."""
    return [page(path) for path in sorted(folder.glob("*.ipynb"))]


def page(path: Path) -> Page:
    """One notebook as a page."""
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    parts: list[str] = []
    pictures: dict[str, bytes] = {}
    for cell in cells:
        text = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            parts.append(text)
            continue
        parts.append(f"```python\n{text}\n```")
        for kind, content in _shown(cell.get("outputs", [])):
            if kind == "text":
                parts.append(f"```text\n{content.rstrip()}\n```")
            else:
                name = f"{path.stem}-{len(pictures) + 1}.png"
                pictures[name] = content
                parts.append(f"![{_said(parts)}]({name})")
    link = f"*A notebook: `notebooks/{path.name}`.*"
    title, *rest = parts
    head, _, below = title.partition("\n")
    return Page(path.stem, "\n\n".join([head, link, below, *rest]) + "\n", pictures)


def _shown(outputs: list[dict[str, Any]]) -> Iterator[tuple[str, Any]]:
    """Yields what a cell shows: texts, and pictures as bytes."""
    for output in outputs:
        data = output.get("data", {})
        if output["output_type"] == "stream":
            yield "text", _COLOURS.sub("", "".join(output["text"]))
        elif "image/png" in data:
            yield "png", base64.b64decode("".join(data["image/png"]))
        elif "text/plain" in data:
            yield "text", "".join(data["text/plain"])


def _said(parts: list[str]) -> str:
    """Words for a picture: the last heading before it."""
    headings = [line for part in parts for line in part.splitlines() if line.startswith("#")]
    said = headings[-1].lstrip("# ") if headings else "Figure"
    return re.sub(r"[\[\]`*]", "", f"Figure: {said}")
