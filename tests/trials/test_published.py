"""The rates in README and docs are those of the scores that the repository keeps."""

import json
from pathlib import Path

import pytest

from scripts import _markdown as markdown
from trials import pool
from trials.table import sheets

ROOT = Path(__file__).parent.parent.parent


KEPT = ROOT / "scripts" / "blind_trials"


def tables_of(folder: Path) -> list[str]:
    """Over all, by size, by effect."""
    scored = pool(
        [json.loads(f.read_text(encoding="utf-8")) for f in sorted(folder.glob("*.json"))]
    )
    return [markdown.table(sheet.heads, sheet.rows) for sheet in sheets(scored)]


@pytest.fixture(scope="module")
def tables() -> list[str]:
    return tables_of(KEPT)


def test_the_readme_quotes_the_rates():
    """Its paragraph has a few cells of the table that the docs have whole, word for word."""
    text = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    scored = pool([json.loads(f.read_text(encoding="utf-8")) for f in sorted(KEPT.glob("*.json"))])
    rows = {row[0]: row[1:] for row in sheets(scored)[0].rows}
    hidden, detectable = rows["cause, first named"]
    alarms, _ = rows["false alarms, nothing hidden"]
    assert f"trial diagnosed {scored['cases']} virtual rigs" in text
    assert f"named first in {hidden}, and in {detectable} of" in text
    assert f"{alarms} raised a false alarm" in text


def test_the_docs_have_all_tables(tables):
    text = (ROOT / "docs" / "blind_trial.md").read_text(encoding="utf-8")
    for table in tables:
        assert table in text


def test_the_docs_have_the_rates_of_the_later_trial():
    text = (ROOT / "docs" / "blind_trial.md").read_text(encoding="utf-8")
    assert tables_of(KEPT / "again")[0] in text
