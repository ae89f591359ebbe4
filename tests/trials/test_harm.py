"""What counts as harm on runs that were never given."""

import hashlib
import json

import numpy as np
import pytest

from tests.trials.conftest import diagnosis_of, part_of_key, put
from tp_jax.errors import InputError
from trials.harm import NOTHING, asked, kept_file, measured_harm, worse

ONES = np.ones(4)


def test_worse_beyond_tolerance_and_chance():
    before = np.full(4, 1.0)
    assert worse(before, before * 1.05, ONES) is True
    assert worse(before, before * 1.01, ONES) is False  # 2 % are tolerated
    assert worse(before, before * 0.5, ONES) is False
    # standard error of the mean change .05: .1 / 2
    scatter = 0.1 * np.sqrt(0.75) * np.array([1.0, -1.0, 1.0, -1.0])
    assert worse(before, before + 0.06 + scatter, ONES) is False
    assert worse(before, before + 0.08 + scatter, ONES) is True
    assert worse(np.array([1.0]), np.array([1.03]), np.ones(1)) is True


def test_weights():
    before, after = np.ones(2), np.array([1.5, 0.9])
    assert worse(before, after, np.array([1e9, 1.0])) is True
    assert worse(before, after, np.array([1.0, 1e9])) is False


def test_what_cannot_be_integrated():
    before, lost = np.ones(2), np.array([1.0, np.nan])
    assert worse(before, lost, np.ones(2)) is True
    assert worse(lost, before, np.ones(2)) is False
    assert worse(lost * np.nan, before, np.ones(2)) is None


def test_asked_only_of_what_adds_something(tmp_path):
    entry = part_of_key("case-001", "none", {})
    nothing, found = diagnosis_of("no_gap"), diagnosis_of("explained", ["column_tilt"])
    assert not asked(nothing)
    assert not asked(found | {"fits": {"before": {}, "after": None}})
    known = found | {"fits": {"before": {}, "after": {"effects": {"column_tilt": {}}}}}
    assert asked(known)
    assert measured_harm(tmp_path, entry, nothing) == NOTHING
    strange = found | {"fits": {"before": {}, "after": {"effects": {"of_another_version": {}}}}}
    assert measured_harm(tmp_path, entry, strange) == NOTHING


def test_is_kept(tmp_path):
    entry = part_of_key("case-001", "none", {})
    found = diagnosis_of("explained", ["column_tilt"])
    found["fits"] = {"before": {}, "after": {"effects": {"column_tilt": {}}}}
    put(tmp_path, "case-001", found)
    kept = kept_file(tmp_path, "case-001")
    digest = hashlib.sha256(kept.with_name("diagnosis.json").read_bytes()).hexdigest()
    kept.write_text(json.dumps({"diagnosis_sha256": digest, "windowed": True, "free_run": False}))
    assert measured_harm(tmp_path, entry, found) == {"windowed": True, "free_run": False}
    for text in (
        '{"diagnosis_sha256": "of another", "windowed": true, "free_run": null}',
        "{",
        "[]",
    ):
        kept.write_text(text)
        with pytest.raises(InputError, match="case-001"):  # measured anew, without recordings here
            measured_harm(tmp_path, entry, found)
