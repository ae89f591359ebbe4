"""Effects that a fleet's rigs share, in plain numbers, as fleet.json has them under "shared"."""

from collections.abc import Sequence
from typing import Any

from tp_jax.gap.policy import POLICY, SharedPolicy
from tp_jax.gap.shared.pooling import NORMAL, Pooled
from tp_jax.gap.shared.scores import RigScores, ScoredVariant
from tp_jax.gap.shared.selection import SharedEffect, shared_effects

SMALLEST_BIRGE = 1.0
"""Intervals are widened by the root of Q over its degrees of freedom where that is above this, and
never narrowed (Birge 1932, Phys. Rev. 40:207)."""


def shared_table(
    rigs: Sequence[RigScores],
    without: Sequence[str] = (),
    seed: int = 0,
    policy: SharedPolicy = POLICY.shared,
) -> dict[str, Any]:
    """Effects that the rigs share or that are some rigs' own, and all that were asked.

    Args:
        rigs: scores of those that have any.
        without: names of rigs that have none.
        seed: of the draws of noise alone.
        policy: what decides.

    Returns:
        "reason": a sentence where nothing could be asked, else None; "rigs", "left_out": names;
        "level"; "effects": those that were named; "candidates": all, the most significant first.
    """
    known: dict[str, Any] = {
        "reason": None,
        "rigs": [rig.rig for rig in rigs],
        "left_out": list(without),
        "level": policy.level,
        "effects": [],
        "candidates": [],
    }
    if len(rigs) < policy.rigs:
        return known | {"reason": too_few(len(rigs), policy)}
    found = shared_effects(rigs, seed, policy)
    return known | {
        "effects": [_effect(rigs, each) for each in found.effects],
        "candidates": [
            {
                "effect": each.pooled.key[0],
                "location": _variant(rigs, each.pooled).location,
                "rigs": len(each.pooled.parts),
                "reduction": each.pooled.drop,
                "p": each.p,
            }
            for each in found.candidates
        ],
    }


def too_few(count: int, policy: SharedPolicy = POLICY.shared) -> str:
    """Says why nothing is asked of so many rigs."""
    there = {0: "none was", 1: "one was"}.get(count, f"{count} were")
    return (
        f"Effects that rigs share need at least {policy.rigs} rigs that could be diagnosed, and "
        f"{there}; add campaigns."
    )


def _variant(rigs: Sequence[RigScores], pooled: Pooled) -> ScoredVariant:
    return rigs[pooled.parts[0].rig].by_key[pooled.key]


def _effect(rigs: Sequence[RigScores], named: SharedEffect) -> dict[str, Any]:
    pooled, agreed = named.pooled, named.agreement
    variant = _variant(rigs, pooled)
    wider = max(agreed.q / agreed.dof if agreed.dof else SMALLEST_BIRGE, SMALLEST_BIRGE) ** 0.5
    amplitudes = {}
    for (name, unit), value, error, limits in zip(
        variant.amplitudes, pooled.estimate, pooled.standard_errors, pooled.limits, strict=True
    ):
        half = NORMAL * wider * error
        ends = [max(value - half, limits[0]), min(value + half, limits[1])]
        amplitudes[name] = {"value": float(value), "unit": unit, "ci95": [float(x) for x in ends]}
    return {
        "effect": variant.effect,
        "location": variant.location,
        "verdict": named.verdict,
        "shapes": dict(variant.shapes),
        "amplitudes": amplitudes,
        "reduction": pooled.drop,
        "p": named.p,
        "heterogeneity": {
            "q": agreed.q,
            "dof": agreed.dof,
            "p": agreed.p,
            "spread": agreed.spread,
        },
        "differ": named.differ,
        "without_largest": {
            "rig": rigs[named.largest].rig,
            "reduction": named.without.drop,
            "p": named.p_without,
        },
        "asked_of": len(pooled.parts),
        "shown_by": [rigs[i].rig for i in named.showing],
        "by_rig": {
            rigs[part.rig].rig: {"factor": factor, "p": p}
            for part, factor, p in zip(pooled.parts, agreed.by_rig, agreed.p_by_rig, strict=True)
        },
        "confused_with": list(named.tied),
    }
