"""The key: who may see it, when, and that nobody changed it."""

import stat

import pytest

from tests.trials.conftest import diagnosis_of, put
from tp_jax.errors import InputError
from trials import score
from trials.seal import open_key, undiagnosed


def test_key_is_its_owners(trial):
    root = trial(("none", {}, None))
    assert stat.S_IMODE((root / "sealed" / "key.json").stat().st_mode) == 0o600
    assert stat.S_IMODE((root / "sealed").stat().st_mode) == 0o700


def test_stays_sealed_until_all_is_diagnosed(trial):
    root = trial(("none", {}, diagnosis_of("no_gap")), ("none", {}, None), ("none", {}, None))
    (root / "sealed" / "key.json").unlink()  # not even looked at
    with pytest.raises(InputError, match=r"2 of 3 have none, the first case-002") as told:
        score(root)
    assert "\n" not in str(told.value)
    assert undiagnosed(root) == ["case-002", "case-003"]


def test_opens_when_all_is_diagnosed(trial):
    root = trial(("none", {}, None))
    put(root, "case-001", diagnosis_of("no_gap"))
    assert [entry["case"] for entry in open_key(root)["cases"]] == ["case-001"]


def test_another_key_is_refused(trial):
    root = trial(("none", {}, diagnosis_of("no_gap")))
    file = root / "sealed" / "key.json"
    file.write_text(file.read_text().replace("none", "two"))
    with pytest.raises(InputError, match="is not the key that"):
        score(root)


def test_cases_taken_away_are_missed(trial):
    root = trial(*[("none", {}, diagnosis_of("no_gap"))] * 2)
    (root / "case-002" / "campaign.toml").unlink()
    with pytest.raises(InputError, match="not those of its key"):
        score(root)


@pytest.mark.parametrize("file", ["KEY.sha256", "case-001/campaign.toml"])
def test_no_trial(trial, file):
    root = trial(("none", {}, diagnosis_of("no_gap")))
    (root / file).unlink()
    with pytest.raises(InputError, match="holds no blind trial"):
        score(root)


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("{", "is not JSON"),
        ("[]", "is not a diagnosis"),
        ('{"schema": "tp-jax/diagnosis/1"}', "has no verdict"),
        ('{"schema": "tp-jax/diagnosis/1", "verdict": "maybe"}', "verdict must be"),
        (
            '{"schema": "tp-jax/diagnosis/1", "verdict": "no_gap", '
            '"provenance": {"data_sha256": {"x": "y"}}}',
            "other data",
        ),
    ],
)
def test_what_is_no_diagnosis_of_the_case(trial, text, part):
    root = trial(("none", {}, diagnosis_of("no_gap")))
    (root / "case-001-diagnosis" / "diagnosis.json").write_text(text)
    with pytest.raises(InputError, match=part):
        score(root)


def test_the_first_cases_alone_may_be_scored(trial):
    gap = diagnosis_of("no_gap")
    root = trial(("none", {}, gap), ("none", {}, gap), ("none", {}, None))
    assert undiagnosed(root, 2) == []
    assert [entry["case"] for entry in open_key(root, 2)["cases"]] == ["case-001", "case-002"]
    assert score(root, first=2)["cases"] == 2
    with pytest.raises(InputError, match="1 of 3 have none"):
        score(root, first=3)
