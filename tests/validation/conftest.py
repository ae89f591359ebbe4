"""Fits of the bench: one of a model that is right, one of recordings with something hidden."""

import dataclasses

import numpy as np
import pytest

from tests.rigs import synthetic_campaign, synthetic_values
from tp_jax.estimation.baseline import prepare_campaign
from tp_jax.estimation.least_squares import fit as fit_windows


def fitted(campaign):
    setting = prepare_campaign(campaign, effects=())
    problem = setting.problem(setting.horizons[-1])
    found = fit_windows(
        problem, synthetic_values(setting), setting.unknowns(), bounds=setting.bounds,
        anchors=setting.anchors(),
    )  # fmt: skip
    return setting, found


@pytest.fixture(scope="session")
def right():
    return fitted(synthetic_campaign(duration=2.0))


@pytest.fixture(scope="session")
def wrong():
    """The rider's angle reads three per cent less in the last recording only."""
    campaign = synthetic_campaign(duration=2.0)
    *others, last = campaign.recordings
    bent = dataclasses.replace(last, phi2=last.phi2 * 0.9, phi1=last.phi1 * 1.05)
    return fitted(dataclasses.replace(campaign, recordings=(*others, bent)))


@pytest.fixture
def rng():
    return np.random.default_rng(3)
