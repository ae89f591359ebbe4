"""One file, whole, well-formed, that fetches nothing and renders whatever may be missing."""

import os
import re
from datetime import date
from html.parser import HTMLParser

import pytest

from scripts._attack.small import fit
from tp_jax.report import run_tables, tables, words
from tp_jax.report.html import render, write_report
from tp_jax.results.diagnosis import DiagnosisRecord

VOID = {"meta", "link", "br", "img", "hr", "input"}
MOST_BYTES = 3_000_000


class Page(HTMLParser):
    """Sees that every element is closed in its turn, and keeps what is looked at below."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.ids: list[str] = []
        self.elements: list[tuple[str, dict]] = []
        self.words: list[str] = []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.handle_startendtag(tag, attrs)
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        found = dict(attrs)
        assert len(found) == len(attrs), "an attribute twice"
        self.elements.append((tag, found))
        if "id" in found:
            self.ids.append(found["id"])

    def handle_endtag(self, tag):
        assert self.open, f"</{tag}> closes nothing"
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)

    @property
    def text(self) -> str:
        return re.sub(r"\s+", " ", " ".join(self.words))

    def all(self, tag: str) -> list[dict]:
        return [attrs for name, attrs in self.elements if name == tag]


@pytest.fixture(scope="module")
def text(any_diagnosis) -> str:
    """The report of each kind of diagnosis in turn, made once."""
    return render(any_diagnosis)


def test_every_kind_renders_well_formed(text):
    page = Page(text)
    assert len(text.encode()) < MOST_BYTES
    assert len(set(page.ids)) == len(page.ids)
    assert len(page.all("h1")) == 1
    assert page.all("meta")[1]["name"] == "viewport"
    for word in ("None", "nan", "NaN", "{{", "Undefined"):
        assert not re.search(rf"(?<![\w-]){re.escape(word)}(?![\w-])", page.text)


def test_nothing_is_fetched(text):
    assert "http://" not in text
    assert "https://" not in text
    page = Page(text)
    assert page.all("script") == []
    for tag, attrs in page.elements:
        for key in ("src", "href", "xlink:href", "data", "srcset"):
            target = attrs.get(key)
            assert target is None or target.startswith(("#", "data:")), (tag, target)
            if target is not None and target.startswith("#"):
                assert target[1:] in page.ids
    for target in re.findall(r"url\(([^)]*)\)", text):
        assert target.startswith("#")
        assert target[1:] in page.ids
    assert "@import" not in text


def test_every_figure_has_a_caption_and_words(text):
    page = Page(text)
    assert len(page.all("figure")) == len(page.all("figcaption"))
    assert all(image.get("alt") for image in page.all("img"))
    drawn = page.all("svg")
    assert all(svg["role"] == "img" and len(svg["aria-label"]) > 20 for svg in drawn)
    assert len(drawn) == 2 * len(page.all("figure"))  # for wide pages and for phones


def test_sections_of_a_full_diagnosis(made):
    text = render(made("explained"))
    for title in (
        "Before and after",
        "When the gap shows",
        "Where the gap lies",
        "Which effect",
        "What this data cannot tell apart",
        "Minimum detectable sizes",
        "Parameters",
        "Next experiment",
        "Notes",
        "Data and provenance",
    ):
        assert f"<h2>{title}</h2>" in text
    said = Page(text).text
    for part in (
        "contact_stribeck",
        "98 %",
        "96 % to 99 %",
        "52.0 mrad",
        "0.550 to 0.610",
        "0.45020",
        "0.44980 to 0.45060",
        "not determined by this data",
        "beyond its range",
        "a1" * 32,
        "reaction_factor",
    ):
        assert part in said


def test_recordings_are_listed_with_their_use(made):
    said = Page(render(made("explained"))).text
    for part in ("run-06.csv", "6 rad/s", "free decay", "held out, never fitted", "2,501"):
        assert part in said


def test_what_is_gone_on_each_recording_stands_beside_it(made):
    diagnosis = made("explained")
    assert "gap gone, not fitted" not in run_tables.data(DiagnosisRecord.read(diagnosis)).head
    diagnosis["gap"]["shrink_by_recording"] = {"run-06.csv": 0.934, "decay.csv": None}
    table = run_tables.data(DiagnosisRecord.read(diagnosis))
    assert table.head[-1] == "gap gone, not fitted"
    assert [row[-1] for row in table.rows] == ["–", "93 %", "–"]
    assert "gap gone, not fitted" in Page(render(diagnosis)).text


def test_errors_stand_by_recording_and_angle(made):
    table = run_tables.runs(DiagnosisRecord.read(made("explained")))
    assert [row[:2] for row in table.rows] == [("run-17.csv", "φ1"), ("run-17.csv", "φ2")]
    windows_before, windows_after = table.rows[1][2:4]
    assert float(windows_before.split()[0]) > 3.0 * float(windows_after.split()[0])
    assert len(table.head) == 7
    assert run_tables.runs(DiagnosisRecord.read(made("unknown"))).head[2:] == (
        "windows",
        "free run",
        "noise",
    )
    assert run_tables.runs(DiagnosisRecord.read(made("bare"))) is None


def test_without_a_cause_there_is_no_after(made):
    diagnosis = made("no_gap")
    diagnosis["gap"]["after"] = dict(diagnosis["gap"]["before"])  # as `diagnose` writes it
    assert "after" not in tables.gap(DiagnosisRecord.read(diagnosis)).head


def test_a_floor_of_two_parts_is_said(made):
    diagnosis = made("explained")
    parts = {"noise": {"phi1": 1e-3, "phi2": 1e-3}, "calibration": {"phi1": 0.0, "phi2": 5e-4}}
    for calibration, there in ((5e-4, True), (0.0, False), (None, False)):
        parts["calibration"]["phi2"] = calibration
        diagnosis["noise_floor_parts"] = parts
        said = Page(render(diagnosis)).text.replace("\u00a0", " ")
        assert ("φ2 1.00 mrad of noise and 0.500 mrad that its calibration" in said) == there
        assert "φ1 1.00 mrad of noise" not in said


def test_structure_that_is_left_is_said(made):
    diagnosis = made("explained")
    for p, there in ((0.012, True), (0.4, False), (None, False)):
        diagnosis["gap"]["structure_p_after"] = p
        assert ("What is left still has structure" in render(diagnosis)) == there


def test_a_motion_too_sparse_to_map_is_said(made):
    pytest.importorskip("matplotlib")
    diagnosis = made("explained")
    assert "There is no map over angle and velocity" not in render(diagnosis)
    for key in ("curves", "residuals"):
        entry = diagnosis[key][0]
        entry["t"] = entry["t"][::20]
        for channel in ("phi1", "phi2"):
            entry[channel] = {k: y[::20] for k, y in entry[channel].items()}
    assert "There is no map over angle and velocity" in render(diagnosis)


def test_texts_are_escaped(made):
    text = render(made("explained") | {"campaign": "<b>&", "notes": ["<script>x</script>"]})
    assert "<b>&" not in text
    assert "&lt;b&gt;&amp;" in text
    assert Page(text).all("script") == []


def test_captions_are_escaped_in_figures(made):
    pytest.importorskip("matplotlib")
    diagnosis = made("explained")
    diagnosis["curves"][0]["recording"] = 'a"><script>.csv'
    page = Page(render(diagnosis))
    assert page.all("script") == []
    assert any('a"><script>.csv' in svg["aria-label"] for svg in page.all("svg"))


def test_same_diagnosis_same_bytes(made):
    assert render(made("explained")) == render(made("explained"))


def test_many_and_long_recordings_stay_light(made):
    diagnosis = made("explained")
    for key in ("curves", "residuals"):
        entry = diagnosis[key][0]
        long = {"recording": "long.csv", "t": list(range(12_000))}
        for channel in ("phi1", "phi2"):
            long[channel] = {k: 20 * y for k, y in entry[channel].items()}
        diagnosis[key] = [long] * 12
    text = render(diagnosis)
    assert len(text.encode()) < MOST_BYTES


def test_written_whole_or_not_at_all(made, tmp_path, monkeypatch):
    path = tmp_path / "report.html"
    write_report(made("bare"), path)
    old = path.read_text(encoding="utf-8")
    assert old.startswith("<!DOCTYPE html>")

    def refused(*_):
        raise OSError("no")

    monkeypatch.setattr(os, "replace", refused)
    with pytest.raises(OSError, match="no"):
        write_report(made("unknown"), path)
    assert path.read_text(encoding="utf-8") == old
    assert list(tmp_path.iterdir()) == [path]


def test_devices_stay_devices(made):
    write_report(made("bare"), os.devnull)
    assert not os.path.isfile(os.devnull)


def test_every_effect_has_words():
    from tp_jax.effects import catalogue

    assert set(catalogue()) <= set(words.EFFECTS)


def test_contents_lead_to_every_part(text):
    page = Page(text)
    led = [a["href"][1:] for a in page.all("a")]
    parts = [s["id"] for s in page.all("section") if "id" in s]
    assert led == (parts if len(parts) > 1 else [])


def test_dates_and_scale(made):
    diagnosis = made("explained")
    diagnosis["recordings"][0]["started"] = "2026-11-23T10:00:00+00:00"
    diagnosis["recordings"][1]["started"] = "2026-11-20T10:00:00+00:00"
    diagnosis["fits"] = {"before": fit(), "after": None}
    diagnosis["fits"]["before"]["parameters"]["B1"] = 1.284614e-3
    said = Page(render(diagnosis, day=date(2026, 11, 26))).text
    assert "recorded 2026-11-20 to 2026-11-23" in said
    assert "report of 2026-11-26" in said
    assert "B1 = 0.001284614 kg m²" in said
    diagnosis["fits"]["before"]["parameters"]["B1"] = 1.0
    assert "per unit of B1" in Page(render(diagnosis)).text
    assert "report of" not in Page(render(diagnosis)).text


def test_long_tables_are_folded_away(made):
    page = Page(render(made("explained")))
    folded = len(page.all("details"))
    assert folded == len(page.all("summary")) == 2  # further candidates, and why one does not apply
    diagnosis = made("explained")
    diagnosis["parameters"] = {f"p{i}": diagnosis["parameters"]["k"] for i in range(30)}
    assert len(Page(render(diagnosis)).all("details")) == folded + 1


def test_why_an_effect_does_not_apply(made):
    diagnosis = made("explained")
    diagnosis["candidates"][-1]["note"] = "Does not apply: it needs B1 and B2 from elsewhere."
    said = Page(render(diagnosis)).text
    assert "Why 1 effect does not apply" in said
    assert "it needs B1 and B2 from elsewhere." in said


def test_a_table_is_parted_only_where_that_hides_something():
    whole = tables.made(("a",), [(str(i),) for i in range(7)])
    assert tables.first_rows(whole, 6) == (whole, None)
    first, rest = tables.first_rows(whole, 5)
    assert [row[0] for row in first.rows + rest.rows] == list("0123456")
    assert tables.first_rows(None, 5) == (None, None)
