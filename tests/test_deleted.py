"""scripts/deleted: rigs whose effect is left out of the diagnosis."""

import dataclasses
import json

import pytest

from scripts import _deleted as study
from tp_jax.effects import catalogue, laws

ROW = study.Row(
    1,
    "0.1.0",
    "bearing_position",
    12.0,
    "explained",
    ("bearing_dry.phi1",),
    0.99,
    0.97,
    0.98,
    False,
    300.0,
)


def test_every_effect_has_a_law_that_acts_where_it_does():
    for id, family in study.FAMILY.items():
        assert catalogue()[id].hook == laws()[family].hook


def test_each_effect_comes_first_once_before_one_does_again():
    many = len(study.FAMILY)
    firsts = [study.effects_of(n)[0] for n in range(1, 2 * many + 1)]
    assert set(firsts[:many]) == set(firsts[many:]) == set(study.FAMILY)
    assert set(study.effects_of(3)) == set(study.FAMILY)


@pytest.mark.parametrize(
    ("causes", "right"),
    [
        (("bearing_dry.phi1",), True),
        (("bearing_dry.v1", "bearing_dry.phi1"), False),
        (("drive_harmonics",), False),
        ((), False),
    ],
)
def test_what_counts_as_right(causes, right):
    assert dataclasses.replace(ROW, causes=causes).right is right


def test_a_formula_of_the_same_law_counts_as_the_law():
    row = dataclasses.replace(ROW, effect="spring_hardening", causes=("spring_asymmetry",))
    assert row.right


def test_the_table_counts_by_size(tmp_path):
    poor = dataclasses.replace(ROW, number=2, multiple=2.0, shrink=0.2, causes=(), verdict="no_gap")
    unseen = dataclasses.replace(poor, number=3, shrink=None, best=None)
    file = tmp_path / "l.jsonl"
    rows = [ROW, poor, unseen]
    file.write_text("".join(json.dumps(dataclasses.asdict(row)) + "\n" for row in rows))
    assert study.read(file) == rows
    small, _, large, every = study.table(rows).splitlines()[2:]
    assert small == "| 2 | 0 to 3 | 0 of 2 | 0 of 2 | 0 of 1 | 0 of 2 | 0 of 2 | 300 |"
    assert large == "| 1 | from 10 | 1 of 1 | 1 of 1 | 1 of 1 | 1 of 1 | 0 of 1 | 300 |"
    assert every.startswith("| 3 | from 0 | 1 of 3 |")
