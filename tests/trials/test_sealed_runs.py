"""The best that is possible on runs that are never given."""

import numpy as np
import pytest

from tp_jax.estimation.prepared_campaign import prepare_campaign
from tp_jax.estimation.start import initial_values
from tp_jax.gap.held_out import evaluate
from tp_jax.rig import RigParameters, make_campaign
from trials.sealed_runs import together, true_model

NOISE, HIDDEN = 1e-3, "sensor2_nonlinearity"


@pytest.mark.slow
def test_the_true_model_leaves_noise(tmp_path):
    common = dict(effects={HIDDEN: 0.3}, duration=3.0, noise=NOISE)
    given = make_campaign(tmp_path / "case", RigParameters(), runs=3, seed=1, **common)
    make_campaign(tmp_path / "sealed" / "case", RigParameters(), runs=2, seed=2, **common)
    campaign = together(tmp_path, "case", [])
    assert [r.held_out for r in campaign.recordings] == [False] * 3 + [True] * 2
    setting = prepare_campaign(campaign)
    found = true_model(setting, {"given": given}, 0.5)
    assert found is not None
    assert np.sqrt(found.mean_square()) == pytest.approx(NOISE, rel=0.1)
    without = evaluate(setting, initial_values(setting), 0.5)
    assert without.mean_square() > 2.0 * found.mean_square()
    outside = {**given, "effects": {"motor_stall": given["effects"][HIDDEN]}}
    assert true_model(setting, {"given": outside}, 0.5) is None
