"""The table and the page of a fleet, made of saved diagnoses; the page in a browser."""

import csv
import io
import os
import sys

import pytest

from tests.report.browser import Seen, browser
from tests.report.conftest import KINDS, fit_with
from tp_jax.report.fleet.files import csv_text, write_parquet
from tp_jax.report.fleet.page import render
from tp_jax.report.fleet.rows import COLUMNS, by_cause, counts, failed, in_order, row
from tp_jax.report.fleet.shared import told as of_shared
from tp_jax.report.fleet.text import summary

SCREENS = {"desk": (1280, 800), "phone": (390, 844)}
SENTENCE = "rigs/worn/run-13.csv has no column t; name it in [format.columns]."


def made(**changes):
    return {**KINDS["explained"](), **changes}


@pytest.fixture(scope="module")
def rows():
    """Rigs of every kind, among them one without anything and one that failed."""
    found = [
        row(f"{kind}-{i}", KINDS[kind](), f"{kind}-{i}/report.html") for i, kind in enumerate(KINDS)
    ]
    weak = made()
    weak["causes"][0]["parameters"]["strength"]["value"] = 0.22
    weak["gap"]["shrink"] = 0.61
    return in_order([*found, row("weak", weak, "weak/report.html"), failed("worn", SENTENCE)])


def test_rows_have_all_columns_and_kinds(rows):
    for one in rows:
        assert list(one) == list(COLUMNS)
        for name, kind in COLUMNS.items():
            assert one[name] is None or isinstance(one[name], kind), name


def test_rows_are_in_the_order_of_what_can_be_repaired(rows):
    verdicts = [one["verdict"] for one in rows]
    assert verdicts == sorted(verdicts, key=("explained", "unknown", "no_gap", "failed").index)
    assert rows[-1]["error"] == SENTENCE
    assert sum(counts(rows).values()) == len(rows)


def test_causes_are_grouped_the_most_frequent_first(rows):
    groups = by_cause(rows)
    sizes = [len(group) for group in groups.values()]
    assert sizes == sorted(sizes, reverse=True)
    assert next(iter(groups)) == "contact_stribeck"


def without_inertia(name="contact_cogging", unit="N m"):
    """A rig whose B1 was not given, and the same rig with it, both with a torque as cause."""
    pair = []
    for B1 in (1.0, 1.2e-3):
        one = made()
        one["causes"][0]["parameters"] = {
            "a": {"value": 0.3 * B1, "ci95": [0.2 * B1, 0.4 * B1], "unit": unit}
        }
        one["causes"][0]["effect"] = name
        one["fits"] = {"before": fit_with(B1), "after": None}
        pair.append(row(f"rig-{B1}", one))
    return pair


def test_torques_of_a_rig_whose_inertia_was_not_given_are_per_unit_of_it():
    assert [one["unit"] for one in without_inertia()] == ["N m/B1", "N m"]
    assert [one["unit"] for one in without_inertia(unit="rad")] == ["rad", "rad"]
    page = render(in_order(without_inertia()), "two")
    assert "0.3 N m/B1" in page.replace("0.300", "0.3")
    assert "0.150" not in page  # no median of numbers in two units


def test_csv_has_all_digits_and_nothing_for_nothing(rows):
    lines = list(csv.DictReader(io.StringIO(csv_text(rows))))
    for line, one in zip(lines, rows, strict=True):
        for name, kind in COLUMNS.items():
            assert (kind(line[name]) if line[name] else None) == one[name]


def test_parquet_is_the_same_table(rows, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet", reason="needs the extra `parquet`")
    assert write_parquet(rows, tmp_path / "fleet.parquet")
    assert parquet.read_table(tmp_path / "fleet.parquet").to_pylist() == rows


def test_without_pyarrow_there_is_no_parquet(rows, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    assert not write_parquet(rows, tmp_path / "fleet.parquet")
    assert list(tmp_path.iterdir()) == []


def test_the_terminal_has_a_line_a_rig(rows):
    lines = summary(rows).splitlines()
    assert len(lines) == 2 + len(rows)
    assert lines[-1] == f"worn: {SENTENCE}"
    assert summary([failed("a", "No.")]) == "1 rig: 1 failed\na: No."


@pytest.fixture(scope="module")
def shared():
    """What rigs share, of every kind."""
    kind = {
        "effect": "spring_asymmetry",
        "location": "spring",
        "verdict": "kind",
        "shapes": {},
        "amplitudes": {"a": {"value": 0.0012, "unit": "1", "ci95": [0.0009, 0.0015]}},
        "reduction": 60.0,
        "p": 0.0005,
        "differ": False,
        "heterogeneity": {"q": 9.0, "dof": 11, "p": 0.6, "spread": 0.0},
        "without_largest": {"rig": "<rig>", "reduction": 45.0, "p": 0.0005},
        "asked_of": 12,
        "shown_by": [],
        "by_rig": {},
        "confused_with": ["elastic_stop"],
    }
    own = {
        **kind,
        "effect": "contact_wear",
        "verdict": "own",
        "differ": True,
        "shown_by": ["worn"],
        "confused_with": [],
        "heterogeneity": {"q": 90.0, "dof": 11, "p": 1e-9, "spread": 2.0},
    }
    return {
        "reason": None,
        "rigs": [f"rig-{i}" for i in range(12)],
        "left_out": ["torn"],
        "level": 0.01,
        "effects": [kind, own],
        "candidates": [{"effect": "x", "p": 0.4}],
    }


def test_what_rigs_share_is_told_in_sentences(shared):
    found = of_shared(shared)
    assert found.summary == "The 12 rigs share one effect. torn could not be asked."
    (kind,), (own,) = found.kind, found.own
    assert kind.does == "the spring is stiffer in one sense of winding than in the other"
    assert kind.sentences == (
        "Its size is a 0.00120 (0.00090 to 0.00150), the same on all 12 rigs that it applies to. "
        "Noise alone gives as much to any effect with p < 0.001. Without <rig>, which shows most "
        "of it, 75 % of the evidence is left. No rig shows it alone. The fleet cannot tell it from "
        "elastic_stop."
    )
    assert own.sentences == (
        "worn shows it, of 12 rigs that it applies to. The rigs do not agree on its size "
        "(p < 0.001)."
    )
    nothing = of_shared({**shared, "effects": [], "left_out": []})
    assert nothing == (
        "The 12 rigs share no effect that their recordings show: noise alone gives as much as the "
        "most likely one, x, with p = 0.40.",
        [],
        [],
    )
    assert of_shared({"reason": "Too few."}) == ("Too few.", [], [])
    single = {**shared["effects"][1], "differ": False, "shown_by": []}
    assert of_shared({**shared, "effects": [single]}).own[0].sentences == (
        "None of the 12 rigs that it applies to shows it alone. Without <rig> too little of the "
        "evidence is left."
    )


def test_the_terminal_has_the_same_sentences(rows, shared):
    text = summary(rows, shared)
    assert text.startswith(summary(rows))
    assert "\nThe kind's effects: spring_asymmetry, the spring is stiffer" in text
    assert "\nA rig's own: contact_wear, " in text


def test_the_page_says_what_rigs_share(rows, shared):
    text = render(rows, "rigs", shared=shared)
    assert "<h2>What the rigs share</h2>" in text
    assert "<h3>A rig&#39;s own</h3>" in text
    assert "&lt;rig&gt;" in text
    assert "<rig>" not in text
    assert "What the rigs share" not in render(rows, "rigs")


def test_names_are_escaped():
    text = render([failed("<script>alert(1)</script>", "a & b")], "<b>", day=None)
    assert "<script>alert" not in text
    assert "a &amp; b" in text
    assert "<title>&lt;b&gt;" in text


@pytest.fixture(scope="module")
def chromium():
    with browser() as found:
        yield found


@pytest.fixture(scope="module")
def page_file(rows, shared, tmp_path_factory):
    file = tmp_path_factory.mktemp("fleet") / "fleet.html"
    file.write_text(render(rows, "rigs", shared=shared), encoding="utf-8")
    return file


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("screen", list(SCREENS))
def test_reads_well(chromium, page_file, screen, scheme):
    width, height = SCREENS[screen]
    page = chromium.new_page(viewport={"width": width, "height": height}, color_scheme=scheme)
    seen = Seen(page, page_file)
    assert seen.said == []
    assert seen.asked == []
    assert not seen.too_wide
    assert seen.axe() == []
    folder = os.environ.get("TP_JAX_TESTS_PICTURES")
    if folder:
        page.screenshot(path=f"{folder}/fleet-{screen}-{scheme}.png", full_page=True)
    page.close()


def shown(page):
    return page.evaluate(
        "[...document.querySelectorAll('#rigs tbody tr')].filter((row) => !row.hidden)"
        ".map((row) => row.cells[0].firstChild.textContent)"
    )


def test_sorts_and_filters(chromium, page_file, rows):
    page = chromium.new_page()
    seen = Seen(page, page_file)
    assert shown(page) == [one["rig"] for one in rows]
    page.click("#rigs thead button:text-is('Rig')")
    names = [one["rig"] for one in rows]
    assert shown(page) == sorted(names)
    page.click("#rigs thead button:text-is('Rig')")
    assert shown(page) == sorted(names, reverse=True)
    page.click("#rigs thead button:text-is('Shrink')")
    known = sorted(one["shrink"] for one in rows if one["shrink"] is not None)
    shrinks = {one["rig"]: one["shrink"] for one in rows}
    told = [shrinks[name] for name in shown(page)]
    assert told[: len(known)] == known
    assert set(told[len(known) :]) == {None}, "what is not known comes last"
    assert page.get_attribute("#rigs th:has(button:text-is('Shrink'))", "aria-sort") == "ascending"
    page.select_option("select[data-key=cause]", "contact_stribeck")
    mine = [one["rig"] for one in rows if one["cause"] == "contact_stribeck"]
    assert sorted(shown(page)) == sorted(mine)
    page.fill("#search", "WEAK")
    assert shown(page) == ["weak"]
    assert page.inner_text("#count") == f"1 of {len(rows)} rigs"
    assert seen.said == []
    page.close()


def test_without_a_script_the_table_is_whole(chromium, page_file, rows):
    context = chromium.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto(page_file.as_uri())
    assert page.locator("#rigs tbody tr").count() == len(rows)
    assert not page.is_visible("#filters")
    context.close()
