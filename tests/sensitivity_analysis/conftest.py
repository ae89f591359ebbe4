"""One analysis of a small campaign, as the command line would make it."""

import pytest

from tests.rigs import synthetic_campaign
from tp_jax.sensitivity_analysis.analysis import sensitivity

SMALL = dict(samples=16, trajectories=8, points=3, seed=1)


@pytest.fixture(scope="session")
def campaign():
    return synthetic_campaign(duration=1.6)


@pytest.fixture(scope="session")
def analysis(campaign):
    return sensitivity(campaign, **SMALL, profile=("k",))
