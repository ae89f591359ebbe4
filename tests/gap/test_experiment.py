"""Runs that are proposed: with the noise of the rig, and as long as its motion needs."""

import dataclasses

import numpy as np
import pytest

from tests.rigs import synthetic_campaign, synthetic_values
from tests.standing_in import standing_in
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.prepared_campaign import prepare_campaign
from tp_jax.estimation.variable_projection import fit
from tp_jax.gap.experiment import propose, rehearsal
from tp_jax.gap.screen import Scored
from tp_jax.recordings.colour import Colour


class Seen(Exception):
    """Length [s] and number of the runs that are looked at."""


def fitted():
    setting = prepare_campaign(synthetic_campaign(duration=2.0), effects=())
    problem = setting.problem(setting.horizons[-1])
    return setting, fit(problem, synthetic_values(setting), setting.unknowns(), max_iterations=1)


def test_a_run_on_paper_has_the_noise_of_those_that_were_made():
    setting, found = fitted()
    slow = (Colour(neighbours=0.6, rho=0.8), Colour())
    coloured = tuple(dataclasses.replace(p, colour=slow) for p in setting.prepared)
    run = rehearsal(dataclasses.replace(setting, prepared=coloured), found, 1.0)([None])
    assert run.prepared[0].colour == slow
    np.testing.assert_array_equal(run.prepared[0].sigma, setting.prepared[0].sigma)


def test_a_slow_rig_is_asked_for_slow_and_long_runs(monkeypatch):
    """Two decimals of a frequency of 0.004 rad/s are none, and ten seconds no motion."""
    setting, found = fitted()

    def looked(given, fit, duration):
        def problem_of(readings):
            raise Seen(duration, len(readings))

        return problem_of

    monkeypatch.setattr("tp_jax.gap.experiment.rehearsal", looked)
    runs = tuple(
        dataclasses.replace(r, omega=r.omega and 3e-4 * r.omega) for r in setting.recordings
    )
    campaign = dataclasses.replace(setting.campaign, recordings=runs)
    slow = dataclasses.replace(setting, period=1.6e3, campaign=campaign)
    one = standing_in(Scored)
    with pytest.raises(Seen) as seen:
        propose(slow, standing_in(Fit, values=found.values), one, one)
    assert seen.value.args == (1.6e4, 6)  # six different frequencies
