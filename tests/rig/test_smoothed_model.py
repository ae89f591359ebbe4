"""The rig against the package's own model, whose dry friction is smoothed."""

import numpy as np
import pytest

import tp_jax as tp
from tests.reference import BENCH, reference
from tp_jax.rig import VirtualRig

TS = np.arange(2501) / 250.0


def rms(a, b) -> np.ndarray:
    return np.sqrt(np.mean((a - b) ** 2, axis=0))


def test_bench_agrees_with_the_model():
    motion = tp.simulate(tp.presets.get("bench"), TS)
    model = np.stack([motion.phi1, motion.phi2], axis=1)
    # a fifth of the noise of a reading: stuck bodies of the model creep
    assert (rms(VirtualRig().run(TS, omega=BENCH["omega"]), model) < 2e-4).all()


@pytest.mark.parametrize("omega", [8.0, 17.0, 22.0])
def test_what_is_left_is_the_smoothing(omega):
    hard = VirtualRig().run(TS, omega=omega)
    left = [
        rms(hard, reference(BENCH | dict(omega=omega, eps=eps), TS, rtol=1e-9, atol=1e-11)[:, :2])
        for eps in (5e4, 1e6)
    ]
    assert (left[0] < 2e-4).all()
    # in proportion to 1 / eps, or nearly
    assert (left[1] < left[0] / 5.0).all()
