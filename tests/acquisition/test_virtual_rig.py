"""The simulator behind the firmware's protocol, recorded in real time: here, where no other test
takes the processors from it."""

import time

import numpy as np
import pytest

from tests.acquisition.swing import port_of
from tp_jax.acquisition import Settings, record
from tp_jax.recordings import read_columns
from tp_jax.rig.emulator import Firmware
from tp_jax.rig.serve import Emulator
from tp_jax.rig.simulator import VirtualRig


@pytest.mark.parametrize("speed", [None, 1.0, 8.0])
def test_the_virtual_rig_through_the_port(speed, tmp_path):
    """What is recorded is what the simulator's sensors saw, but for the noise."""
    effects = {"contact_stribeck": 0.4}
    firmware = Firmware(VirtualRig(effects=effects, seed=2), run_duration=4.0)
    # at eight times real time the simulator may fall behind, which is no skew of a clock
    settings = Settings(4.0, omega=13.09, real_time=speed == 1.0)
    with Emulator(firmware, speed=speed) as rig:
        begin = time.perf_counter()
        done = record(port_of(rig), tmp_path / "run.csv", settings)
        took = time.perf_counter() - begin
    values = read_columns(done.path).values
    t = np.arange(4001) / 1000
    np.testing.assert_array_equal(values["t"], t)
    true = VirtualRig(effects=effects, seed=2).run(t, omega=13.09)
    for i, name in enumerate(("phi1", "phi2")):
        off = values[name] - true[:, i]
        assert off.std() == pytest.approx(1e-3, rel=0.05)
        assert abs(off.mean()) < 1e-4
    assert (done.metadata["clock"] is None) is (speed != 1.0)
    assert took < 10.0
