"""No sentence contradicts the numbers beside it, whatever they are."""

import itertools
import random

import pytest

from tp_jax.gap.held_out import Shrink
from tp_jax.gap.policy import POLICY
from tp_jax.gap.verdict import Evidence, verdict
from tp_jax.report.text import summary

P = (0.0, 2.7e-4, 0.02499, 0.025, 0.04999, 0.05, 0.4, 1.0)
PROBABILITY = (0.5, 0.8, 0.9, 0.999)
TOLERANCE = (0.0, 2e-3)
SHRINKS = (
    Shrink(0.999, (0.99, 1.0), True),
    Shrink(0.6, (0.3, 0.8), True),
    Shrink(None, None, False),
)
LEVEL, ALARM = POLICY.structure.level, POLICY.structure.alarm


def combinations():
    """All pairs of p; of the rest, which have 144 combinations, each is beside eight of them."""
    pairs = list(itertools.product(P, P))
    others = list(itertools.product((0, 1, 2), PROBABILITY, TOLERANCE, SHRINKS, (0.0, 40.0)))
    random.Random(0).shuffle(others)
    for i, rest in enumerate(others * 8):
        yield (*pairs[i % len(pairs)], *rest)


def diagnosis(made, p, p_after, causes, probability, tolerance, shrink, rest):
    """What a diagnosis says with this evidence."""
    rms = 1e-3 * rest**0.5
    evidence = Evidence(
        p,
        p_after,
        causes,
        probability,
        shrink,
        rest,
        0.03,
        gap_rms=5e-3,
        rest_rms=rms,
    )
    word = verdict(evidence, tolerance)
    d = made("explained")
    d["verdict"] = word
    first = d["causes"][0]
    names = ("contact_stribeck", "column_tilt")[: causes if word != "no_gap" else 0]
    d["causes"] = [{**first, "effect": n, "probability": probability} for n in names]
    d["gap"] |= {
        "structure_p": p,
        "structure_p_after": p_after if names else None,
        "tolerance": tolerance,
        "shrink": shrink.value,
        "shrink_ci95": shrink.ci95 and list(shrink.ci95),
        "removable_significant": shrink.significant,
    }
    return d


def test_no_sentence_contradicts_a_number(made):
    seen = set()
    for p, p_after, *rest in combinations():
        d = diagnosis(made, p, p_after, *rest)
        text = summary(d)
        seen.add(d["verdict"])
        assert ("looks like noise" in text) == (p >= ALARM)
        assert ("No gap was found" in text) == (p >= ALARM)
        assert ("below the tolerance" in text) == (d["verdict"] == "no_gap" and p < ALARM)
        assert ("The gap is explained\n" in text) == (d["verdict"] == "explained")
        assert ("There is a gap that is not explained" in text) == (
            d["verdict"] == "unknown" and not d["causes"]
        )
        if d["verdict"] == "no_gap":
            assert "cause:" not in text
            continue
        assert p < ALARM
        if "no structure beside" in text:
            assert p_after >= LEVEL
        if "still has structure" in text:
            assert p_after < LEVEL
            assert ("something small" in text) == (d["verdict"] == "explained")
    assert seen == {"explained", "no_gap", "unknown"}


@pytest.mark.parametrize("p", P)
def test_the_text_says_p(made, p):
    d = diagnosis(made, p, 1.0, 0, 0.9, 1.0, SHRINKS[2], 0.0)
    assert d["verdict"] == "no_gap"
    assert ("p < 0.001" in summary(d)) == (p < 1e-3)
