"""Forecasts of runs, by a baseline of recordings of the virtual rig."""

import types

import numpy as np
import pytest

from tp_jax.estimation.baseline import grow, initial_values, prepare_campaign
from tp_jax.gap.forecast import forecasts, natural_frequency
from tp_jax.gap.next_run import NOTHING, Run
from tp_jax.gap.refit import Refit
from tp_jax.recordings import hold_out, load_campaign
from tp_jax.rig import BENCH, VirtualRig
from tp_jax.rig.campaign import make_campaign

DURATION = 3.0
RUNS = (Run(omega=9.0), Run(release=0.3))


def test_natural_frequency():
    numbers = {"k": 0.45, "B1": 1.2e-3, "B2": 5e-4}
    found = natural_frequency({"fits": {"before": {"parameters": numbers}}})
    assert found == pytest.approx(16.27, abs=0.01)


@pytest.mark.slow
def test_angles_come_true_and_no_run_tells_a_model_from_itself(tmp_path):
    folder = tmp_path / "rig"
    make_campaign(folder, BENCH, {"contact_stribeck": 0.5}, runs=3, duration=DURATION, seed=4)
    setting = prepare_campaign(hold_out(load_campaign(folder)))
    fit = grow(setting, initial_values(setting), setting.unknowns())
    first = types.SimpleNamespace(before=fit, refits={})
    choice = types.SimpleNamespace(rounds=(first,), causes=(), final=Refit(fit, ()))
    found = forecasts(setting, choice, None, (NOTHING,), RUNS, DURATION, None)
    assert [f.run for f in found] == list(RUNS)
    for forecast in found:
        rig = VirtualRig(BENCH, {"contact_stribeck": 0.5})
        rig.start(omega=forecast.run.omega, release=forecast.run.release)
        times = np.arange(0.01, DURATION, 0.01).tolist()
        swung = max(max(map(abs, rig.motion(t)[:2])) for t in times)
        assert forecast.largest == pytest.approx(swung, rel=0.1)
        assert forecast.log_evidence[NOTHING] < 0.02
