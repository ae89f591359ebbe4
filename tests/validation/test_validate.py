"""Everything together, and what becomes of it in `identify`."""

import json

from tp_jax.cli.output import json_text
from tp_jax.validation import validate

KEYS = {"code", "parameters", "text"}


def test_a_right_model(right):
    setting, fit = right
    found = validate(fit, setting)
    table = json.loads(json_text(found.to_dict()))
    assert {"profile", "consistency", "reduction", "residuals"} <= set(table)
    codes = {w["code"] for w in found.warnings}
    assert "inconsistent" not in codes
    assert "residuals" not in codes


def test_a_wrong_one(wrong):
    setting, fit = wrong
    stages = []
    found = validate(fit, setting, progress=lambda stage, part: stages.append(stage))
    codes = {w["code"] for w in found.warnings}
    assert {"inconsistent", "residuals"} <= codes
    for w in found.warnings:
        assert set(w) == KEYS
        assert w["text"].endswith(".")
        assert w["text"].count("\n") == 0
    assert {"recordings alone", "smaller baselines"} <= set(stages)
