"""Effects that a rig gets, and how large: in multiples of what its recordings could just show."""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from tp_jax.rig.effects import catalogue
from trials.detectable import minimum_detectable
from trials.draw import largest
from trials.plan import Case
from trials.projection import Bench

SMALLEST, LARGEST = 1.0, 10.0  # times the minimum detectable size, uniform in the logarithm


def hide(
    case: Case, bench: Bench, allowed: Callable[[str], bool], rng: np.random.Generator
) -> tuple[dict[str, dict[str, Any]], dict[str, float], list[str]]:
    """The first preferred effects that this rig can show, sized; shapes; what was passed over.

    Args:
        case: what is wanted. bench: on which it is to show. rng: chance.
        allowed: whether recordings of this kind can tell of an effect at all.
    """
    hidden: dict[str, dict[str, Any]] = {}
    shapes: dict[str, float] = {}
    passed_over: list[str] = []
    for id in case.preferred:
        if len(hidden) == case.wanted:
            break
        draw = catalogue()[id].draw(rng, bench.parameters)
        level = math.log(LARGEST / SMALLEST) * rng.random()
        if not allowed(id):
            passed_over.append(id)
            continue
        factor = minimum_detectable(bench, id, draw.sizes, draw.shapes)
        most = largest(id, draw.sizes) / factor
        if most < SMALLEST:
            passed_over.append(id)
            continue
        # what would be implausibly large is drawn anew, up to what is plausible
        multiple = SMALLEST * math.exp(level)
        if multiple > most:
            multiple = SMALLEST * (most / SMALLEST) ** rng.random()
        hidden[id] = {
            "sizes": tuple(multiple * factor * x for x in draw.sizes),
            "multiple": multiple,
            "factor": factor,
        }
        shapes |= draw.shapes
    return hidden, shapes, passed_over


def reference(hidden: Mapping[str, Mapping[str, Any]]) -> dict[str, dict[str, float]]:
    """The rig's own scale of what is hidden, for the key."""
    return {
        id: {"multiple": each["multiple"], "factor": each["factor"]} for id, each in hidden.items()
    }
