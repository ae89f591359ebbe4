"""CITATION.cff says of the package what the package says of itself."""

import re
import tomllib
from pathlib import Path

import tp_jax

ROOT = Path(__file__).parent.parent
TEXT = (ROOT / "CITATION.cff").read_text(encoding="utf-8")


def of(key: str) -> str:
    found = re.search(rf"^{key}: (.*)$", TEXT, re.MULTILINE)
    assert found is not None, key
    return found[1]


def test_version_licence_and_words():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert of("version") == tp_jax.__version__
    assert of("license") == project["license"]
    assert re.findall(r"^  - ([^:\n]*)$", TEXT, re.MULTILINE) == project["keywords"]


def test_the_paper_is_the_reference():
    readme = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    title = re.search(r"title: >-\n\s+(Modeling.*)", TEXT)
    assert title is not None
    assert title[1].strip() in readme
    assert "year: 2015" in TEXT
