"""What the page on adding an effect says, done to the letter: from outside the package."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs" / "adding_an_effect.md"

_FILE = re.compile(r'^```python title="([^"]+)"\n(.*?)^```', re.DOTALL | re.MULTILINE)


def files() -> dict[str, str]:
    """The files that the page shows, by name, in its order."""
    return dict(_FILE.findall(PAGE.read_text(encoding="utf-8")))


def test_the_page_shows_three_files():
    assert list(files()) == ["my_effects.py", "make_campaign.py", "diagnose.py"]


def test_its_lines_fit_a_page():
    assert max(len(line) for text in files().values() for line in text.splitlines()) <= 100


@pytest.mark.slow
def test_an_effect_of_ones_own_is_screened_refitted_and_reported(tmp_path):
    import json

    for name, text in files().items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    # what the page leaves to the reader: to look at the numbers
    script = tmp_path / "diagnose.py"
    keep = "\nimport json\n\nfrom tp_jax.cli.output import json_text\n"
    keep += "\nopen('diagnosis.json', 'w').write(json_text(diagnosis))\n"
    script.write_text(script.read_text(encoding="utf-8") + keep, encoding="utf-8")
    environment = os.environ | {"PYTHONPATH": str(ROOT), "EQX_ON_ERROR": "nan"}
    said = ""
    for name in ("make_campaign.py", "diagnose.py"):
        done = subprocess.run(
            [sys.executable, name], cwd=tmp_path, env=environment, capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr
        said = done.stdout

    diagnosis = json.loads((tmp_path / "diagnosis.json").read_text(encoding="utf-8"))
    row = next(c for c in diagnosis["candidates"] if c["effect"] == "contact_spin")
    assert row["predicted_shrink"] > 0.5, "screened"
    assert row["realised_shrink"] > 0.8, "refitted"
    assert row["location"] == "contact"
    assert diagnosis["minimum_detectable"]["contact_spin"]["unit"] == "s^2/rad^2"
    assert [cause["effect"] for cause in diagnosis["causes"]] == ["contact_spin"]
    size = diagnosis["causes"][0]["parameters"]["a"]
    assert size["value"] == pytest.approx(-0.004, rel=0.15)  # what make_campaign.py has hidden
    assert "contact_spin" in said
    report = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "contact_spin" in report
    assert "s²/rad²" in report
