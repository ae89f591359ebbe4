"""Frequency of a vibration between the points of its grid, of a rig integrated by the reference."""

import dataclasses

import pytest

from tests.rigs import synthetic_campaign, synthetic_values
from tp_jax.effects import catalogue
from tp_jax.estimation.prepared_campaign import prepare_campaign
from tp_jax.estimation.variable_projection import fit
from tp_jax.gap import frequency
from tp_jax.gap.screen import screen

FAR = 14.7
"""Hz; the grid has 12 and 18."""


def searched(effect="", hidden=None):
    """A campaign with two effects in its layout, and the fit of its baseline."""
    campaign = synthetic_campaign(effect=effect, hidden=hidden, duration=5.0)
    effects = [catalogue()[id] for id in ("contact_vibration", "spring_hardening")]
    setting = prepare_campaign(campaign, effects=effects)
    found = fit(
        setting.problem(setting.horizons[-1]),
        synthetic_values(setting),
        setting.unknowns(),
        bounds=setting.bounds,
        priors=setting.priors(),
        max_iterations=60,
    )
    return setting, found


@pytest.fixture(scope="module")
def vibrating():
    return searched("contact_vibration", {"a": 0.3, "b": 0.1, "W": FAR})


def test_a_vibration_between_the_grid_s_points_is_found(vibrating):
    setting, found = vibrating
    seen = screen(found, setting)
    on_grid = max(s.drop for s in seen.scored if s.id == "contact_vibration")
    best = next(s for s in frequency.tuned(setting, found, seen).best())
    assert best.id == "contact_vibration"
    assert dict(best.variant.shapes)["W"] == pytest.approx(FAR, abs=0.05)
    assert best.drop > 2.0 * on_grid
    assert best.drop <= found.cost


def test_it_is_not_asked_where_another_effect_takes_the_gap(vibrating, monkeypatch):
    setting, found = vibrating
    seen = screen(found, setting)
    plain = [
        s if s.id == "contact_vibration" else dataclasses.replace(s, drop=0.9 * found.cost)
        for s in seen.scored
    ]
    monkeypatch.setattr(frequency, "likeliest", lambda *_: pytest.fail("asked"))
    seen = dataclasses.replace(seen, scored=tuple(plain))
    assert frequency.tuned(setting, found, seen) is seen


def test_noise_promises_no_frequency():
    """Of so many frequencies the best one takes something; that is taken off."""
    setting, found = searched()
    _, drop = frequency.likeliest(setting, found)
    assert drop < 20.0  # of six amplitudes, 3.5 standard deviations of what they take by chance
