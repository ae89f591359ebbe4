"""The key to a campaign: what is hidden in it, and what differs from run to run."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tp_jax.rig.effects import catalogue
from tp_jax.rig.simulator import VirtualRig


def hidden_effects(rig: VirtualRig) -> dict[str, dict[str, Any]]:
    """id -> sizes, units, shape constants and place of every effect in a rig."""
    return {
        id: {
            "sizes": dict(zip(known.amplitudes, rig.effects[id], strict=True)),
            "unit": list(known.unit),
            "shapes": rig.shapes[id],
            "location": known.location,
            "channel": known.channel,
            "in_catalogue": known.in_catalogue,
        }
        for id in rig.effects
        for known in (catalogue()[id],)
    }


def values_by_run(
    rig: VirtualRig, plan: Sequence[Mapping[str, float]]
) -> list[dict[str, tuple[float, ...]]]:
    """Returns what differs from run to run, for each of them."""
    drawn = []
    for kind in plan:
        rig.start(omega=kind.get("omega"), release=kind.get("release"))
        drawn.append(dict(rig.run_values))
    for id in rig.run_values:
        if catalogue()[id].relative:
            mean = np.mean([own[id] for own in drawn], axis=0)
            for own in drawn:
                own[id] = tuple((np.array(own[id]) - mean).tolist())
    return drawn
