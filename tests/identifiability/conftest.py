"""A fit whose truth is known: the bench, white noise, two seconds of three recordings."""

import pytest

from tests.rigs import synthetic_campaign, synthetic_values
from tp_jax.estimation.prepared_campaign import prepare_campaign
from tp_jax.estimation.variable_projection import fit as fit_windows


@pytest.fixture(scope="session")
def setting():
    return prepare_campaign(synthetic_campaign(duration=2.0), effects=())


@pytest.fixture(scope="session")
def fit(setting):
    """From the truth on, windows of the last length at once: what is asked of is the end."""
    problem = setting.problem(setting.horizons[-1])
    return fit_windows(
        problem,
        synthetic_values(setting),
        setting.unknowns(),
        bounds=setting.bounds,
        priors=setting.priors(),
    )
