"""Rivals in the place of a cause, and causes found before: which effect is fitted then."""

from types import SimpleNamespace

import numpy as np

from tp_jax.estimation.layout import Unknown, Values
from tp_jax.gap import backward
from tp_jax.gap.refit import Refit
from tp_jax.gap.worth_refitting import known_first


def variant(id):
    return SimpleNamespace(effect=SimpleNamespace(id=id), unknowns=(Unknown(f"{id}.a", None),))


A, B, C, D, RIVAL = map(variant, ("a", "b", "c", "d", "rival"))
LAYOUT = SimpleNamespace(index={f"{v.effect.id}.a": i for i, v in enumerate((A, B, C, D, RIVAL))})


def refitted(variants, numbers):
    return Refit(SimpleNamespace(values=Values(LAYOUT, np.array(numbers)[:, None])), variants)


def test_the_rival_of_a_round_whose_first_cause_is_gone(monkeypatch):
    """A was taken first, B in addition to it; then C took the place of A, and D came."""
    asked = []
    monkeypatch.setattr(backward, "refit", lambda *args: asked.append(args))
    monkeypatch.setattr(backward.dataclasses, "replace", lambda fit, values: values)
    now = refitted((C, B, D), [0.0, 2.0, 3.0, 4.0, 0.0])
    then = refitted((A, RIVAL), [1.0, 0.0, 0.0, 0.0, 5.0])
    backward._instead(None, now, B, then)
    ((_, values, variants),) = asked
    assert variants == [C, RIVAL, D]
    assert values.table[:, 0].tolist() == [0.0, 0.0, 3.0, 4.0, 5.0]


def test_a_cause_found_before_is_refitted_where_it_helps_most():
    near, far = (SimpleNamespace(id="a", drop=drop) for drop in (5.0, 50.0))
    other = SimpleNamespace(id="b", drop=20.0)
    seen = SimpleNamespace(scored=(near, far, other), best=lambda: [far, other])
    known = SimpleNamespace(ids=("a",))
    current = SimpleNamespace(ids=())
    assert known_first(seen, [other], current, known) == [far, other]
