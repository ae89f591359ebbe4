"""Effects with corners against the virtual rig, which goes from corner to corner."""

import numpy as np
import pytest

from tests.reference import BENCH
from tp_jax.effects import Applied, get
from tp_jax.model import presets
from tp_jax.rig import VirtualRig
from tp_jax.simulation import simulate

TS = np.arange(501) / 250.0
CASES = {
    "bearing_load": ({"a": 0.1}, {}),
    "spring_deadzone": ({"g": 0.015}, {}),
    "elastic_stop": ({"a": 20.0, "b": 5.0}, {"s": 0.2}),
}


@pytest.mark.parametrize("id", CASES)
def test_moves_like_the_rig(id):
    sizes, shapes = CASES[id]
    hidden = {f"{id}.{n}": x for n, x in shapes.items()}
    rig = VirtualRig(effects={id: tuple(sizes.values())}, shapes=hidden)
    term = Applied(get(id), {n: np.float64(x) for n, x in (sizes | shapes).items()})
    for omega in (8.0, 17.0):
        model = presets.double_pendulum(**BENCH | dict(omega=omega, eps=1e6), terms=(term,))
        run = simulate(model, TS)
        found, seen = np.stack([run.phi1, run.phi2], axis=1), rig.run(TS, omega=omega)
        # what is left is the smoothing, as without an effect
        np.testing.assert_allclose(found, seen, rtol=0.0, atol=2e-4)
        assert np.abs(seen - VirtualRig().run(TS, omega=omega)).max() > 0.01


def test_a_column_that_nothing_pulls():
    # in the play of its spring for good: the error of a step has no frequency to go by
    term = Applied(get("spring_deadzone"), {"g": np.float64(0.2)})
    model = presets.double_pendulum(**BENCH | dict(A=0.1), terms=(term,))
    run = simulate(model, TS, np.array([0.0, 0.0, 0.2, 0.0]))
    assert np.isfinite(run.phi1).all()
    assert 0.0 < run.phi1[-1] < 0.05
