"""The rates in README and docs are those of the scores that the repository keeps."""

import json
from pathlib import Path

import pytest

from scripts import _markdown as markdown
from tp_jax.blind import pool
from tp_jax.blind.table import sheets

ROOT = Path(__file__).parent.parent.parent


@pytest.fixture(scope="module")
def tables() -> list[str]:
    """Over all, by size, by effect."""
    files = sorted((ROOT / "scripts" / "blind_trials").glob("*.json"))
    scored = pool([json.loads(file.read_text(encoding="utf-8")) for file in files])
    return [markdown.table(sheet.heads, sheet.rows) for sheet in sheets(scored)]


def test_the_readme_has_the_rates(tables):
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert tables[0] in text
    assert tables[1] in text


def test_the_docs_have_all_tables(tables):
    text = (ROOT / "docs" / "blind_trial.md").read_text(encoding="utf-8")
    for table in tables:
        assert table in text
