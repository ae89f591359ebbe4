"""A headless Chromium for the tests of what people see; they are skipped where there is none."""

import importlib.util
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome")

# nothing that a browser does of its own accord
ARGUMENTS = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)


@contextmanager
def browser() -> Iterator[Any]:
    """Chromium, with a profile that is new and goes when it ends."""
    reason = "needs a browser: install Chromium, and playwright and axe-core-python in .venv"
    playwright = pytest.importorskip("playwright.sync_api", reason=reason)
    program = next(filter(None, map(shutil.which, NAMES)), None)
    if program is None or importlib.util.find_spec("axe_core_python") is None:
        pytest.skip(reason)
    with playwright.sync_playwright() as running:
        found = running.chromium.launch(executable_path=program, args=list(ARGUMENTS))
        yield found
        found.close()


class Seen:
    """A page as it is seen, with what it said to the console and what it asked of the network."""

    def __init__(self, page: Any, place: Path | str):
        self.page = page
        self.said: list[str] = []
        self.asked: list[str] = []
        page.on("console", lambda message: self.said.append(message.text))
        page.on("pageerror", lambda fault: self.said.append(str(fault)))
        page.on("request", lambda request: self._ask(request.url))
        page.goto(place if isinstance(place, str) else place.resolve().as_uri())

    def _ask(self, url: str) -> None:
        if not url.startswith(("file:", "data:", "blob:")):
            self.asked.append(url)

    def axe(self, *, grave: bool = False) -> list[str]:
        """What axe finds wrong, contrast included: rule and element; all of it or the grave."""
        spec = importlib.util.find_spec("axe_core_python")
        assert spec is not None
        assert spec.origin is not None
        script = Path(spec.origin).parent / "axe.min.js"
        self.page.evaluate(script.read_text(encoding="utf-8"))
        found = self.page.evaluate("axe.run(document, {resultTypes: ['violations']})")
        return [
            f"{fault['id']}: {node['html'][:120]}"
            for fault in found["violations"]
            if not grave or fault["impact"] in ("serious", "critical")
            for node in fault["nodes"]
        ]

    def box(self, selector: str) -> dict[str, float] | None:
        """Where the first visible element of this kind lies [px]."""
        for element in self.page.query_selector_all(selector):
            if element.is_visible():
                return element.bounding_box()
        return None

    @property
    def too_wide(self) -> bool:
        """Whether the page must be moved sideways to be read."""
        return self.page.evaluate(
            "document.documentElement.scrollWidth > document.documentElement.clientWidth"
        )
