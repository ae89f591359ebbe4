"""The report in a browser: on a desk and on a phone, on light and on dark screens, on paper."""

import pytest

from tests.report.browser import Seen, browser
from tp_jax.report import write_report

pytest.importorskip("matplotlib")

SCREENS = {"desk": (1280, 800), "phone": (390, 844)}
PAPER = 718  # px: the width of A4 between the margins of the style sheet


@pytest.fixture(scope="module")
def chromium():
    with browser() as found:
        yield found


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Reports by kind, each made once."""
    from tests.report.conftest import KINDS

    folder = tmp_path_factory.mktemp("reports")
    paths = {kind: folder / f"{kind}.html" for kind in KINDS}
    for kind in ("explained", "no_gap", "unknown", "single", "bare"):
        write_report(KINDS[kind](), paths[kind], figures=False)
    return paths


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("screen", list(SCREENS))
@pytest.mark.parametrize("kind", ["explained", "no_gap", "unknown", "single", "bare"])
def test_reads_well(chromium, written, kind, screen, scheme):
    width, height = SCREENS[screen]
    page = chromium.new_page(viewport={"width": width, "height": height}, color_scheme=scheme)
    seen = Seen(page, written[kind])
    assert seen.said == []
    assert seen.asked == []
    assert not seen.too_wide
    assert seen.axe() == []
    heading = seen.box("h1")
    assert heading is not None
    assert heading["y"] + heading["height"] < height
    picture = seen.box("figure svg")
    if kind != "bare":
        assert picture is not None
        assert picture["y"] + picture["height"] <= height, "the picture is above the fold"
    page.close()


@pytest.mark.parametrize("kind", ["explained", "no_gap"])
def test_fits_paper(chromium, written, kind):
    page = chromium.new_page(viewport={"width": PAPER, "height": 1000}, color_scheme="dark")
    page.emulate_media(media="print")
    seen = Seen(page, written[kind])
    assert not seen.too_wide
    white = page.evaluate("getComputedStyle(document.body).backgroundColor")
    assert white == "rgb(255, 255, 255)"
    assert len(page.pdf(format="A4")) > 10_000
    page.close()
