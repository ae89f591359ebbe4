"""Rivals in the place of a cause, and causes found before: which effect is fitted then."""

from types import SimpleNamespace

import numpy as np

from tests.standing_in import standing_in
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.layout import Layout, Unknown, Values
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.gap import backward
from tp_jax.gap.directions import Variant
from tp_jax.gap.refit import Refit
from tp_jax.gap.screen import Scored, Screen
from tp_jax.gap.worth_refitting import known_first


def variant(id):
    return standing_in(Variant, effect=SimpleNamespace(id=id), unknowns=(Unknown(f"{id}.a", None),))


A, B, C, D, RIVAL = map(variant, ("a", "b", "c", "d", "rival"))
LAYOUT = standing_in(
    Layout, index={f"{v.effect.id}.a": i for i, v in enumerate((A, B, C, D, RIVAL))}
)


def refitted(variants, numbers):
    return Refit(standing_in(Fit, values=Values(LAYOUT, np.array(numbers)[:, None])), variants)


def test_the_rival_of_a_round_whose_first_cause_is_gone(monkeypatch):
    """A was taken first, B in addition to it; then C took the place of A, and D came."""
    asked = []
    now = refitted((C, B, D), [0.0, 2.0, 3.0, 4.0, 0.0])
    monkeypatch.setattr(backward, "refit", lambda *args: asked.append(args) or now)
    monkeypatch.setattr(backward.dataclasses, "replace", lambda fit, values: values)
    then = refitted((A, RIVAL), [1.0, 0.0, 0.0, 0.0, 5.0])
    backward._instead(standing_in(PreparedCampaign), now, B, then)
    ((_, values, variants),) = asked
    assert variants == [C, RIVAL, D]
    assert values.table[:, 0].tolist() == [0.0, 0.0, 3.0, 4.0, 5.0]


def test_a_cause_found_before_is_refitted_where_it_helps_most():
    near, far = (standing_in(Scored, id="a", drop=drop) for drop in (5.0, 50.0))
    other = standing_in(Scored, id="b", drop=20.0)
    seen = standing_in(Screen, scored=(near, far, other), best=lambda: [far, other])
    known = standing_in(Refit, ids=("a",))
    current = standing_in(Refit, ids=())
    assert known_first(seen, [other], current, known) == [far, other]
