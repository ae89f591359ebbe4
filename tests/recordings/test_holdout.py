"""What is held out where nothing is marked."""

from pathlib import Path

import numpy as np
import pytest

from tp_jax.recordings import Campaign, hold_out


@pytest.fixture
def campaign(recording):
    """Makes a campaign of forced runs (a frequency) and decays (None)."""

    def make(*omegas, **given):
        recordings = tuple(
            recording(name=f"{i}.csv", omega=omega, forced=omega is not None, **given)
            for i, omega in enumerate(omegas)
        )
        return Campaign("c", "double", None, None, None, None, recordings, Path())

    return make


@pytest.mark.parametrize(
    ("omegas", "held"),
    [
        ((None, 6.0, 10.0, 13.09, 17.0, 22.0), 4),
        ((22.0, 17.0, 13.09, 10.0, 6.0), 1),  # by frequency, not by place
        ((6.0, 10.0, 13.0), 2),
        ((None, 6.0, 10.0), 2),
        ((6.0, None, None), 2),  # the only forced run stays to be fitted
        ((None, None, None), 2),
    ],
)
def test_one_whole_recording(campaign, omegas, held):
    before = campaign(*omegas)
    after = hold_out(before)
    assert [each.name for each in after.held_out] == [f"{held}.csv"]
    assert [each.name for each in after.recordings] == [each.name for each in before.recordings]
    assert not before.held_out
    assert hold_out(after) is after


def test_another_one_can_be_named(campaign):
    after = hold_out(campaign(6.0, 10.0, 13.0, 17.0), instead=1)
    assert [each.name for each in after.held_out] == ["1.csv"]


def test_last_of_a_single_recording(campaign):
    fitted, held = hold_out(campaign(13.0)).recordings
    assert (fitted.held_out, held.held_out) == (False, True)
    assert fitted.n + held.n == 500
    assert fitted.n == pytest.approx(350, abs=1)
    assert fitted.t[-1] < held.t[0]
    assert fitted.name == held.name == "0.csv"
    assert fitted.label != held.label
    assert held.span[1] == held.t[-1]


def test_the_longer_of_two_is_cut(campaign, recording):
    t = np.arange(1000) / 250.0
    long = recording(name="long.csv", t=t, phi1=np.sin(t), phi2=np.sin(t))
    pair = campaign(13.0)
    both = Campaign("c", "double", None, None, None, None, (*pair.recordings, long), Path())
    assert [each.name for each in hold_out(both).recordings] == ["0.csv", "long.csv", "long.csv"]


def test_decay_is_cut_while_it_moves(campaign):
    t = np.arange(2500) / 250.0
    noise = 1e-3 * np.random.default_rng(0).standard_normal((2, t.size))
    phi = np.where(t < 2.0, 0.25 * (2.0 - t) * np.cos(15.0 * t), 0.0)
    fitted, held = hold_out(campaign(None, t=t, phi1=phi + noise[0], phi2=noise[1])).recordings
    assert 1.2 < fitted.t[-1] < 1.4
    assert held.t[-1] == t[-1]
