"""Forecasts of runs, by a baseline of recordings of the virtual rig."""

import types

import numpy as np
import pytest

from tests.standing_in import standing_in
from tp_jax.estimation.layout import Unknown, Values
from tp_jax.estimation.linearisation import Linearisation
from tp_jax.estimation.prepared_campaign import prepare_campaign
from tp_jax.estimation.schedule import fit_over_schedule
from tp_jax.estimation.start import initial_values
from tp_jax.gap.choice import Choice, Round
from tp_jax.gap.forecast import Alternative, _left, forecasts, natural_frequency
from tp_jax.gap.next_run import NOTHING, Run
from tp_jax.gap.refit import Refit
from tp_jax.recordings import hold_out, load_campaign
from tp_jax.rig import BENCH, VirtualRig
from tp_jax.rig.campaign import make_campaign

DURATION = 3.0
RUNS = (Run(omega=9.0), Run(release=0.3))
NUMBERS = standing_in(Values)


def test_natural_frequency():
    numbers = {"k": 0.45, "B1": 1.2e-3, "B2": 5e-4}
    found = natural_frequency(numbers)
    assert found == pytest.approx(16.27, abs=0.01)


def saved(rng, windows=6, rows=24, slots=("k", "Ts1")):
    """A linearisation of two recordings in windows, as if it had been saved."""
    shape = (windows, rows)
    return Linearisation(
        rng.normal(size=shape),
        rng.normal(size=(*shape, 4)),
        rng.normal(size=(*shape, len(slots))),
        np.ones(shape, bool),
        np.zeros((windows, (rows - 4) // 2, 4)),
        np.ones(windows, bool),
        slots,
        np.arange(windows) % 2,
    )


def of_saved(lin):
    """A problem that answers with a saved linearisation."""
    return types.SimpleNamespace(
        windows=types.SimpleNamespace(recording=lin.recording),
        prepared=(None, None),
        initial_states=lambda values: np.zeros((lin.r.shape[0], 4)),
        linearise=lambda values, states, slots: lin,
    )


def test_a_rival_is_left_with_what_no_fit_of_it_explains():
    lin, prior = saved(np.random.default_rng(0)), np.diag([5.0, 0.5])
    rival = Alternative(NUMBERS, (Unknown("k"), Unknown("Ts1")), prior, 1.0)
    left = _left(of_saved(lin), NUMBERS, rival)
    for run in range(2):
        which = np.flatnonzero(lin.recording == run)
        # the windows' states and the rival's numbers at once, with what is known of these
        full = np.zeros((which.size * 24 + 2, 4 * which.size + 2))
        for j, w in enumerate(which):
            full[24 * j : 24 * (j + 1), 4 * j : 4 * (j + 1)] = lin.states_jac[w]
            full[24 * j : 24 * (j + 1), -2:] = lin.slots_jac[w]
        full[-2:, -2:] = np.sqrt(prior)
        r = np.append(lin.r[which].ravel(), [0.0, 0.0])
        least = r - full @ np.linalg.lstsq(full, r, rcond=None)[0]
        assert left[run] == pytest.approx(least @ least, rel=1e-6)


def test_a_run_that_a_rival_cannot_follow_is_told_and_the_other_judged():
    lin = saved(np.random.default_rng(1))
    lin.complete[1] = False  # a window of the second run
    left = _left(of_saved(lin), NUMBERS, Alternative(NUMBERS, (Unknown("k"),), np.eye(1), 1.0))
    assert np.isfinite(left[0])
    assert np.isnan(left[1])


def test_what_is_known_of_a_rival_leaves_more():
    lin, unknowns = saved(np.random.default_rng(2)), (Unknown("k"), Unknown("Ts1"))
    free, known = (
        _left(of_saved(lin), NUMBERS, Alternative(NUMBERS, unknowns, size * np.eye(2), 1.0))
        for size in (1e-6, 1e6)
    )
    assert (free < known).all()


@pytest.mark.slow
def test_angles_come_true_and_no_run_tells_a_model_from_itself(tmp_path):
    folder = tmp_path / "rig"
    make_campaign(folder, BENCH, {"contact_stribeck": 0.5}, runs=3, duration=DURATION, seed=4)
    setting = prepare_campaign(hold_out(load_campaign(folder)))
    fit = fit_over_schedule(setting, initial_values(setting), setting.unknowns())
    first = standing_in(Round, before=fit, refits={})
    choice = standing_in(Choice, rounds=(first,), causes=(), final=Refit(fit, ()))
    found = forecasts(setting, choice, None, (NOTHING,), RUNS, DURATION, None)
    assert [f.run for f in found] == list(RUNS)
    for forecast in found:
        rig = VirtualRig(BENCH, {"contact_stribeck": 0.5})
        rig.start(omega=forecast.run.omega, release=forecast.run.release)
        times = np.arange(0.01, DURATION, 0.01).tolist()
        swung = max(max(map(abs, rig.motion(t)[:2])) for t in times)
        assert forecast.largest == pytest.approx(swung, rel=0.1)
        assert forecast.log_evidence[NOTHING] < 0.02
