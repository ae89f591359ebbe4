"""The documentation builds without a warning, is complete, and fetches nothing from anywhere."""

import functools
import http.server
import os
import re
import subprocess
import sys
import threading
from html.parser import HTMLParser
from pathlib import Path

import pytest

from tests.report.browser import Seen, browser

ROOT = Path(__file__).parent.parent
REASON = "building the documentation needs the extra `docs`: pip install '.[docs]'"


@pytest.fixture(scope="module")
def site(tmp_path_factory) -> Path:
    """The built documentation."""
    for module in ("material", "mkdocstrings", "latex2mathml", "matplotlib"):
        pytest.importorskip(module, reason=REASON)
    folder = tmp_path_factory.mktemp("site")
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(folder)],
        cwd=ROOT,
        env=os.environ | {"NO_MKDOCS_2_WARNING": "1", "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout + done.stderr == "", "no warnings"
    return folder


class Fetched(HTMLParser):
    """What a page would have a browser fetch, links that a reader follows left out."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.found: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        if tag == "link" and given.get("rel") in ("canonical", "next", "prev"):
            return
        keys = ("src", "srcset", "data") if tag in ("a", "form") else ("src", "srcset", "href")
        self.found += [given[key] for key in keys if given.get(key)]


pytestmark = pytest.mark.slow


def test_nothing_comes_from_elsewhere(site):
    pages = list(site.rglob("*.html"))
    assert len(pages) > 10
    for page in pages:
        for target in Fetched(page.read_text(encoding="utf-8")).found:
            assert not re.match(r"(https?:)?//", target), f"{page.name} fetches {target}"


def test_every_effect_has_a_row_and_a_picture(site):
    from tp_jax.effects import catalogue

    page = (site / "catalogue" / "index.html").read_text(encoding="utf-8")
    for name in catalogue():
        assert f'href="#{name}"' in page
        assert f'id="{name}"' in page
    assert page.count('<figure class="effect">') == len(catalogue())
    assert "\\|" not in page


def test_every_command_is_described(site):
    from tp_jax.cli import build_parser

    page = (site / "commands" / "index.html").read_text(encoding="utf-8")
    for line in build_parser().format_help().splitlines():
        command = re.match(r"    (\w+) {2}", line)
        if command:
            assert f"tp-jax {command[1]}" in page


def test_examples_of_commands_can_be_typed():
    """Each is parsed; nothing is run."""
    import shlex

    from scripts._docs.commands import EXAMPLES
    from tp_jax.cli import build_parser

    for name, lines in EXAMPLES.items():
        for line in lines:
            program, *argv = shlex.split(line, comments=True)
            assert program == "tp-jax"
            assert " ".join(argv).startswith(name)
            build_parser().parse_args(argv)


def test_every_public_name_is_described(site):
    import tp_jax as tp

    page = (site / "python" / "index.html").read_text(encoding="utf-8")
    for name in tp.__all__:
        if callable(getattr(tp, name)):
            assert f'id="tp_jax.{name}"' in page


def test_every_notebook_is_a_page_with_its_pictures(site):
    for notebook in (ROOT / "notebooks").glob("*.ipynb"):
        page = (site / "notebooks" / notebook.stem / "index.html").read_text(encoding="utf-8")
        assert "<img" in page


def test_formulae_are_drawn_by_the_browser(site):
    page = (site / "physics" / "index.html").read_text(encoding="utf-8")
    assert page.count("<math") > 20
    assert "\\(" not in page
    assert "arithmatex" not in page


@pytest.fixture(scope="module")
def served(site):
    """The site at an address of this machine, as a server would have it."""
    quiet = type("Quiet", (http.server.SimpleHTTPRequestHandler,), {"log_message": lambda *_: None})
    server = http.server.ThreadingHTTPServer(
        ("127.0.0.1", 0), functools.partial(quiet, directory=str(site))
    )
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield f"http://127.0.0.1:{server.server_port}"
    server.shutdown()
    thread.join()
    server.server_close()


@pytest.fixture(scope="module")
def chromium():
    with browser() as found:
        yield found


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("name", ["", "physics/", "catalogue/", "adding_an_effect/", "python/"])
def test_pages_read_well(chromium, served, name, scheme):
    page = chromium.new_page(viewport={"width": 1280, "height": 800}, color_scheme=scheme)
    seen = Seen(page, f"{served}/{name}")
    page.wait_for_load_state("networkidle")
    assert seen.said == []
    assert [url for url in seen.asked if not url.startswith(served)] == []
    assert not seen.too_wide
    # the theme's own lists and buttons have flaws that are not grave
    assert seen.axe(grave=True) == []
    page.close()
