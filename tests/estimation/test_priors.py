"""Priors that a campaign states."""

import dataclasses

import pytest

from tests.rigs import synthetic_campaign
from tp_jax.estimation.fitted import parameter
from tp_jax.estimation.layout import Unknown
from tp_jax.estimation.prepared_campaign import prepare_campaign
from tp_jax.recordings.entries import Known

VALUE, SD = 0.2, 0.004


@pytest.mark.parametrize("B1", [1e-4, 1e-3, 5e-3])
def test_a_stiffness_is_where_it_is_stated_on_a_rig_of_any_size(B1):
    campaign = dataclasses.replace(synthetic_campaign(), B1=B1, k=Known(VALUE, SD))
    setting = prepare_campaign(campaign, effects=())
    (prior,) = (a for a in setting.priors() if a.unknown == Unknown("k"))
    # as a fit reads the coordinate
    spec = parameter(setting.problem(setting.horizons[0]), prior.unknown)
    assert float(spec.from_coordinate(prior.mean)) == pytest.approx(VALUE)
    assert prior.sd * spec.slope(VALUE) == pytest.approx(SD)
