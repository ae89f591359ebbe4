"""The model's directions against the virtual rig's own effects, which are made another way.

Networks of sliders where the model has Dahl states, a third body where it has a base without one,
the play operator step by step, Coulomb's friction as a set.
"""

import itertools

import numpy as np
import pytest

from tests.effects.own_states import IDS, OMEGA, TS, angles, bench, cosine, direction, effect
from tp_jax.rig import VirtualRig

#: Sizes that the rig draws, and shape constants between those of the grids where it can.
HIDDEN = {
    "base_compliance": (0.15, {"W": 12.0, "zeta": 0.05}),
    "bearing_presliding": (0.8, {"z0": 0.015}),
    "column_cable": (0.07, {"z0": 0.15}),
    "contact_presliding": (0.8, {"z0": 0.02}),
    "drive_backlash": (0.01, {}),
    "spring_hysteresis": (0.2, {"z0": 0.1}),
}


def change(id: str, size: float, shapes) -> np.ndarray:
    """What the rig's run changes by (n, 2) with an effect."""
    named = {f"{id}.{n}": x for n, x in shapes.items()}
    rigs = VirtualRig(effects={id: size}, shapes=named), VirtualRig()
    with_it, without = (rig.run(TS, omega=OMEGA) for rig in rigs)
    return with_it - without


def best(id: str, seen: np.ndarray) -> np.ndarray:
    """The direction at null that is nearest, over the whole grid of shape constants."""
    grids = [[(s.name, x) for x in s.grid] for s in effect(id).shapes]
    found = [direction(id, dict(point)) for point in itertools.product(*grids)]
    return max(found, key=lambda d: cosine(d, seen))


@pytest.mark.parametrize("id", IDS)
def test_points_where_the_rigs_effect_goes(id):
    size, shapes = HIDDEN[id]
    seen = change(id, size, shapes)
    assert cosine(best(id, seen), seen) > 0.97


@pytest.mark.parametrize("id", IDS)
def test_a_small_effect_is_as_large_as_the_rigs(id):
    size, shapes = HIDDEN[id]
    # a gap must be seen to be a gap
    part = 0.5 if id == "drive_backlash" else 0.02
    seen = change(id, part * size, shapes)
    found = part * size * best(id, seen)
    assert cosine(found, seen) > 0.98
    assert np.linalg.norm(found) == pytest.approx(np.linalg.norm(seen), rel=0.35)


@pytest.mark.parametrize("id", IDS)
def test_the_same_size_does_the_same(id):
    size, shapes = HIDDEN[id]
    (only,) = effect(id).amplitudes
    seen = change(id, size, shapes)
    found = angles(bench(id, {only.name: size} | shapes)) - angles(bench())
    assert cosine(found, seen) > 0.97
    # a network of sliders is no Dahl state: its virgin curve is twice as steep
    part = 0.02 if id in ("base_compliance", "drive_backlash") else 0.3
    assert np.linalg.norm(found - seen) < part * np.linalg.norm(seen)
