"""What the page on adding an effect says, done to the letter: from outside the package."""

import pytest

from tests import kept


def test_the_page_shows_three_files():
    assert list(kept.page_files()) == ["my_effects.py", "make_campaign.py", "diagnose.py"]


def test_its_lines_fit_a_page():
    lines = [line for text in kept.page_files().values() for line in text.splitlines()]
    assert max(map(len, lines)) <= 100


@pytest.mark.slow
def test_an_effect_of_ones_own_is_screened_refitted_and_reported():
    diagnosis = kept.own_effect().to_dict()
    row = next(c for c in diagnosis["candidates"] if c["effect"] == "contact_spin")
    assert row["predicted_shrink"] > 0.5, "screened"
    assert row["realised_shrink"] > 0.8, "refitted"
    assert row["location"] == "contact"
    assert diagnosis["minimum_detectable"]["contact_spin"]["unit"] == "s^2/rad^2"
    assert [cause["effect"] for cause in diagnosis["causes"]] == ["contact_spin"]
    size = diagnosis["causes"][0]["parameters"]["a"]
    assert size["value"] == pytest.approx(-0.004, rel=0.15)  # what make_campaign.py has hidden
    assert "contact_spin" in (kept.own_folder() / "said.txt").read_text(encoding="utf-8")
    report = (kept.own_folder() / "report.html").read_text(encoding="utf-8")
    assert "contact_spin" in report
    assert "s²/rad²" in report
