"""The page in a browser: from dropped files to a report, on desk and phone, light and dark."""

import base64
import os
import threading
from pathlib import Path

import pytest

from tests.report.browser import Seen, browser
from tests.serve.conftest import COMMANDED, RUNS, standing_in
from tp_jax.serve.server import bind

SCREENS = {"desk": (1280, 800), "phone": (390, 844)}
PATIENCE = 60_000.0  # ms: the machine may be busy
PICTURES = "TP_JAX_TESTS_PICTURES"  # a variable: the folder that gets pictures of the page

DROP = """([names, texts]) => {
    const carried = new DataTransfer();
    names.forEach((name, i) => {
        const bytes = Uint8Array.from(atob(texts[i]), (c) => c.charCodeAt(0));
        carried.items.add(new File([bytes], name));
    });
    const told = { dataTransfer: carried, bubbles: true, cancelable: true };
    document.getElementById("drop").dispatchEvent(new DragEvent("drop", told));
}"""


@pytest.fixture(scope="module")
def chromium():
    with browser() as found:
        yield found


@pytest.fixture
def served(folder):
    """A page at an address of this computer, as `tp-jax serve` makes it."""
    bound = bind(folder, child=standing_in())
    thread = threading.Thread(target=bound.run)
    thread.start()
    yield bound
    bound.stop()
    thread.join()


@pytest.fixture(params=SCREENS)
def seen(request, chromium, served):
    """The page on a screen."""
    width, height = SCREENS[request.param]
    page = chromium.new_page(viewport={"width": width, "height": height})
    page.set_default_timeout(PATIENCE)
    yield Seen(page, served.address), request.param
    page.close()


def drop(page, files: list[Path]) -> None:
    texts = [base64.b64encode(file.read_bytes()).decode() for file in files]
    page.evaluate(DROP, [[file.name for file in files], texts])


def reads_well(seen: Seen, name: str) -> None:
    """In light and in dark, of the same page: whoever looks may change that at any time."""
    # A heading may be there before the stylesheet, without which a link is too pale in the dark.
    seen.page.wait_for_load_state("load")
    for scheme in ("dark", "light"):
        seen.page.emulate_media(color_scheme=scheme)
        assert seen.axe() == []
        assert not seen.too_wide
        if os.environ.get(PICTURES):
            picture = f"{os.environ[PICTURES]}/{name}-{scheme}.png"
            seen.page.screenshot(path=picture, full_page=True)


def test_from_dropped_files_to_a_report(seen, served, folder):
    seen, screen = seen
    page = seen.page
    assert "token" not in page.url
    reads_well(seen, f"{screen}-1-empty")

    page.fill("#B1", "1.2e-3")  # before there is a file to say it of
    note = folder.parent / "notes.txt"
    note.write_text("nothing but words\n")
    drop(page, [*RUNS, note])
    page.wait_for_selector("#uploads >> text=7 files were added")
    page.wait_for_selector(".card[data-name='run-22.csv'] svg")
    page.wait_for_selector(".card.bad >> text=notes.txt")
    page.wait_for_selector("#check >> text=can be diagnosed")
    page.wait_for_selector("#start:enabled")
    reads_well(seen, f"{screen}-2-files")

    # a wrong frequency is told at once, and the diagnosis must wait
    field = page.locator(".card[data-name='run-06.csv'] [name=omega]")
    field.fill("37.7")
    page.wait_for_selector("#check .wrong >> text=run-06.csv")
    assert page.is_disabled("#start")
    reads_well(seen, f"{screen}-3-wrong")
    field.fill("")
    page.wait_for_selector("#answer-fault >> text=is missing")
    assert page.is_disabled("#start")
    said = {**COMMANDED, "run_06": "6,0"}
    for name, omega in said.items():
        page.fill(f".card[data-name='{name.replace('_', '-')}.csv'] [name=omega]", omega)
    page.wait_for_selector("#start:enabled")
    assert page.text_content("#answer-fault") == ""
    written = (folder / "campaign.toml").read_text(encoding="utf-8")
    assert "omega = 13.09" in written
    assert "B1 = 0.0012" in written

    page.focus("#start")
    page.keyboard.press("Enter")
    page.wait_for_selector("#stage >> text=fitting windows")
    reads_well(seen, f"{screen}-4-running")
    page.wait_for_selector("#diagnoses >> text=diagnosis-1")
    page.wait_for_selector("#messages >> text=diagnosis-1 is done")
    reads_well(seen, f"{screen}-5-done")

    page.click("#start")
    page.wait_for_selector("#cancel:visible")
    page.keyboard.press("Enter")  # the button has the focus
    page.wait_for_selector("#messages >> text=cancelled")
    page.click("#start")
    page.wait_for_selector("#diagnoses >> text=diagnosis-2")
    page.click("text=Compare >> nth=-1")
    page.wait_for_selector("h1 >> text=side by side")
    reads_well(seen, f"{screen}-6-compare")

    page.click("text=All recordings")
    page.click("#diagnoses a >> text=diagnosis-2")
    page.wait_for_selector("h1 >> text=The gap is explained")
    assert not seen.too_wide
    assert seen.said == []
    own = f"http://127.0.0.1:{served.port}/"
    assert [url for url in seen.asked if not url.startswith(own)] == []


def test_the_keyboard_reaches_everything(chromium, served, folder):
    """In the order in which it is read."""
    page = chromium.new_page()
    page.set_default_timeout(PATIENCE)
    seen = Seen(page, served.address)
    page.set_input_files("#files", [str(RUNS[0]), str(RUNS[1])])
    page.wait_for_selector(".card >> nth=1")
    page.wait_for_selector("#start:enabled")
    page.evaluate("document.activeElement.blur()")
    reached = []
    for _ in range(12):
        page.keyboard.press("Tab")
        reached.append(page.evaluate("document.activeElement.id || document.activeElement.name"))
        if reached[-1] == "start":
            break
    decay, run = ["used", "kind-1"], ["used", "kind-2", "omega"]
    assert reached == ["files", *decay, *run, "B1", "start"]
    assert seen.said == []
    page.close()


def test_a_diagnosis_is_of_what_was_typed_last(chromium, served, folder):
    page = chromium.new_page()
    page.set_default_timeout(PATIENCE)
    Seen(page, served.address)
    page.set_input_files("#files", [str(RUNS[0]), str(RUNS[1])])
    page.wait_for_selector("#start:enabled")
    page.fill("[name=omega] >> visible=true", "37.7")
    page.click("#start")  # before the answers were sent by themselves
    page.wait_for_selector("#check .wrong")
    assert "omega = 37.7" in (folder / "campaign.toml").read_text(encoding="utf-8")
    assert page.is_disabled("#start")
    assert not page.is_visible("#cancel")
    assert not (folder / "diagnosis-1").exists()
    page.fill("[name=omega] >> visible=true", "6")
    page.click("#start >> visible=true")
    page.wait_for_selector("#cancel:visible")
    assert "omega = 6.0" in (folder / "campaign.toml").read_text(encoding="utf-8")
    page.click("#cancel")
    page.wait_for_selector("#messages >> text=cancelled")
    page.close()


def test_a_file_that_is_there_stays(chromium, served, folder):
    (folder / RUNS[0].name).write_text("mine")
    page = chromium.new_page()
    page.set_default_timeout(PATIENCE)
    Seen(page, served.address)
    page.set_input_files("#files", str(RUNS[0]))
    page.wait_for_selector("#uploads .fault >> text=is there already")
    assert (folder / RUNS[0].name).read_text() == "mine"
    page.close()
