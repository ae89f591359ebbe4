"""The rates in README and docs are those of the scores that the repository keeps."""

import json
import re
from pathlib import Path

import pytest

from scripts import _markdown as markdown
from scripts._blind import pool as ledger
from trials import pool
from trials.score import summary
from trials.table import MISSING, measure, sheets

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


def pooled(rigs: str) -> dict:
    """Score of the version, or of the versions together, that docs/blind_trial.md names."""
    text = (ROOT / "docs" / "blind_trial.md").read_text(encoding="utf-8")
    asked = rf"pool pool-{rigs} --score --version ([0-9a-f]{{12}}(?:,[0-9a-f]{{12}})*)"
    (versions,) = set(re.findall(asked, text))
    rows = ledger.read(ledger.POOLS / f"pool-{rigs}.jsonl")
    mine = [row for row in rows if row.version in versions.split(",")]
    return {"cases": len(mine), **summary([ledger.judged_of(row) for row in mine])}


@pytest.fixture(scope="module")
def pools() -> list[dict]:
    return [pooled("clean"), pooled("rough")]


def test_the_readme_quotes_the_pools(pools):
    """Each cell of its table is that of the lines which the repository keeps."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    clean, rough = (of["cases"] for of in pools)
    assert f"| | {clean} clean rigs | {rough} rough: short, coarse, coloured noise |" in text
    for name, of in {
        "cause named first, all sizes": lambda p: p["top1"],
        "from 3 times the detectable size": lambda p: p["from_3"]["top1"],
        "false alarms, nothing hidden": lambda p: p["false_alarm"],
        "both named, two hidden": lambda p: p["both_named"],
        "causes that predict other runs worse": lambda p: p["harm"],
    }.items():
        assert f"| {name} | {' | '.join(measure(of(p)) for p in pools)} |" in text


def test_the_docs_have_the_table_of_the_pools(pools):
    text = (ROOT / "docs" / "blind_trial.md").read_text(encoding="utf-8")
    rows = [{row[0].strip(): row[1:] for row in sheets(p)[0].rows} for p in pools]
    for name in dict.fromkeys([*rows[0], *rows[1]]):
        cells = [cell for of in rows for cell in of.get(name, (MISSING, MISSING))]
        assert f"| {' | '.join([name, *cells])} |" in text


def test_the_docs_have_all_tables(tables):
    text = (ROOT / "docs" / "blind_trial.md").read_text(encoding="utf-8")
    for table in tables:
        assert table in text


def test_the_docs_have_the_rates_of_the_later_trial():
    text = (ROOT / "docs" / "blind_trial.md").read_text(encoding="utf-8")
    assert tables_of(KEPT / "again")[0] in text
