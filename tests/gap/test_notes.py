"""Sentences beside the numbers."""

from types import SimpleNamespace

import numpy as np

from tests.standing_in import standing_in
from tp_jax.effects import catalogue
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.gap.notes import _of_drive_noise, _of_own_sizes, in_one_place
from tp_jax.gap.refit import Refit
from tp_jax.recordings import Campaign, Recording

T = np.arange(2000) / 200.0


def said(*drives):
    """Notes on drives, recording by recording; None where one is commanded."""
    noise = 0.02 * np.random.default_rng(0).standard_normal(T.size)
    runs = tuple(
        Recording.from_arrays(
            T, np.sin(T), name=f"run-{i}.csv", drive=None if d is None else d + noise
        )
        for i, d in enumerate(drives)
    )
    campaign = standing_in(Campaign, recordings=runs)
    return _of_drive_noise(standing_in(PreparedCampaign, campaign=campaign))


SINE, BY_HAND = 0.4 * np.sin(6.0 * T), 0.4 * np.sin(6.0 * T + 0.05 * T**2)


def test_a_periodic_drive_loses_its_noise():
    (note,) = said(SINE, SINE)
    assert "noise of 5" in note
    assert "periodic" in note


def test_a_drive_that_stands_says_nothing_of_an_amplitude():
    """Of two decays and a driven run it is the latter's noise that is told."""
    still = np.full(T.size, 0.1)
    assert "noise of 5" in said(still, SINE, still)[0]
    assert said(still) == []


def test_another_one_is_taken_as_it_reads():
    assert "takes the readings as they are" in said(BY_HAND)[0]
    assert "takes the readings of run-1.csv as they are" in said(SINE, BY_HAND)[0]


def test_a_commanded_drive_has_no_noise():
    assert said(None) == []


def test_a_size_that_was_read_off_the_held_out_run_is_said_to_be():
    def told(*ids):
        variants = tuple(SimpleNamespace(effect=catalogue()[id]) for id in ids)
        return _of_own_sizes(standing_in(Refit, variants=variants))

    assert told("contact_stribeck", "contact_wear") == []
    for id in ("contact_repeatability", "contact_vibration", "drive_frequency"):
        (note,) = told("contact_stribeck", id)
        assert note.startswith(f"{id} ")
        assert "estimated from their readings" in note


def test_causes_in_one_place_may_be_one():
    def told(*ids):
        variants = tuple(SimpleNamespace(effect=catalogue()[id]) for id in ids)
        return in_one_place(standing_in(Refit, variants=variants))

    assert told("contact_stribeck", "spring_hardening") == []
    (note,) = told("contact_presliding", "spring_hardening", "contact_vibration")
    assert note.startswith("contact_presliding and contact_vibration act in one place, contact")
