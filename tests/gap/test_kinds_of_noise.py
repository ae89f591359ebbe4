"""Whatever the noise is like, a rig with nothing hidden raises no alarm, and its size is known."""

import numpy as np
import pytest

from tests import noisy
from tests.standing_in import standing_in
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.noise_levels import with_noise
from tp_jax.estimation.prepared_campaign import prepare_campaign
from tp_jax.estimation.schedule import fit_over_schedule
from tp_jax.estimation.sharpen import fit_with_sharp_friction
from tp_jax.estimation.start import initial_values
from tp_jax.gap import known_noise
from tp_jax.gap.choice import Choice
from tp_jax.gap.held_out import squares
from tp_jax.gap.known_noise import alike, choose_under_noise, with_noise_of
from tp_jax.gap.misfit import misfits
from tp_jax.gap.policy import POLICY
from tp_jax.gap.refit import Refit
from tp_jax.gap.screen import screen
from tp_jax.gap.structure import structure_test
from tp_jax.recordings import Colour

RATE, FAST = (250.0,) * 4, (250.0, 2000.0, 250.0, 2000.0)


def looked_at(noise, seed, rates):
    """A campaign with its noise, and its baseline, as a diagnosis begins."""
    setting = prepare_campaign(noisy.campaign(noise, seed, rates))
    fit = fit_over_schedule(setting, initial_values(setting), setting.unknowns())
    setting, fit = with_noise_of(setting, fit, fit)
    return setting, fit_with_sharp_friction(setting, fit)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("noise", "seeds", "rates", "levels"),
    [
        # A tenth of a second is slow against 250 Hz and lies below every band without motion. There
        # is an alarm at the first seed, as there may be at one of twenty: one of three is let pass.
        (noisy.slow, (1, 2, 3), RATE, (1e-3,) * 4),
        # an error of .3 mrad, and a converter's of .44
        (noisy.coarse, (1,), (100.0,) * 4, (5.35e-4,) * 4),
        (noisy.anticorrelated, (1,), RATE, (1e-3,) * 4),
        # means over blocks of four: the motion needs no more
        (noisy.white, (1,), FAST, (1e-3, 0.5e-3, 1e-3, 0.5e-3)),
        (noisy.louder, (1,), RATE, (2e-3, 2e-3, 1e-3, 1e-3)),
    ],
    ids=["slow", "coarse", "anticorrelated", "two rates", "two levels"],
)
def test_nothing_hidden_is_nothing_found(noise, seeds, rates, levels):
    looks = [looked_at(noise, seed, rates) for seed in seeds]
    alarms = [
        structure_test(screen(fit, setting), seed=0).p < POLICY.structure.seen
        or misfits(setting, fit)
        for setting, fit in looks
    ]
    assert sum(alarms) <= len(seeds) // 3
    for setting, fit in looks:
        its_noise_is_known(setting, fit, noise, levels)


def its_noise_is_known(setting, fit, noise, levels):
    """As it was put in, and as what the right model leaves of held-out data."""
    tolerance = 0.15 if noise is noisy.coarse else 0.1
    found = np.array(setting.levels)
    blocks = np.sqrt(np.array(setting.blocks, dtype=float))[:, None]
    expected = np.array(levels)[:, None] if noise is not noisy.white else 1e-3 / blocks
    np.testing.assert_allclose(found, np.broadcast_to(expected, (4, 2)), rtol=tolerance)
    # however correlated it is
    left = squares(fit)
    noise2 = np.average(setting.levels**2, axis=0, weights=[p.t.size for p in setting.prepared])
    chance = left.chance(np.sqrt(noise2))
    assert left.mean_square() / noise2.mean() == pytest.approx(1.0, abs=0.02 + 3.0 * chance)


@pytest.mark.parametrize(
    ("baseline", "final", "causes", "calls"),
    [
        (9.0, 1.0, ("x",), ["baseline", "chosen", "causes", "chosen"]),
        (11.0, 1.0, ("x",), ["chosen", "causes", "chosen"]),
        # a clock that jumps: 80 times the noise, of which no formula takes anything
        (80.0, 80.0, (), ["chosen"]),
        (80.0, 49.0, ("x",), ["chosen"]),
    ],
)
def test_what_is_left_of_a_large_gap_is_not_asked_for_noise(
    monkeypatch, baseline, final, causes, calls
):
    """It passed for noise of a correlation of .98 on the packaged example."""
    bare = prepare_campaign(noisy.campaign(noisy.white, 1, RATE), effects=())
    first, last = standing_in(Fit, chi2_dof=baseline), standing_in(Fit, chi2_dof=final)
    choice = Choice(standing_in(Fit), (), standing_in(Refit, fit=last, ids=causes))
    found = []

    def with_noise_of(setting, shown, fit):
        found.append("baseline" if shown is first else "causes")
        return setting, fit

    def choose(*_, **__):
        found.append("chosen")
        return choice

    monkeypatch.setattr(known_noise, "with_noise_of", with_noise_of)
    monkeypatch.setattr(known_noise, "choose_or_learn", choose)
    monkeypatch.setattr(known_noise, "learn", lambda *_: choice)
    monkeypatch.setattr(known_noise, "with_residual_noise", lambda setting, _: setting)
    monkeypatch.setattr(known_noise, "alike", lambda *_: False)
    monkeypatch.setattr(known_noise, "with_shapes", lambda *_: ((), {}))
    choose_under_noise(bare, first, 0, print)
    assert found == calls


@pytest.mark.parametrize(
    ("louder", "neighbours", "rho", "same"),
    [
        (1.02, 0.32, 0.52, True),
        (1.10, 0.30, 0.50, False),
        (1.00, 0.40, 0.50, False),
        (1.00, 0.30, 0.80, False),  # as little from sample to sample, and lasting longer
    ],
)
def test_causes_are_chosen_anew_only_under_another_noise(louder, neighbours, rho, same):
    """Two that were nearly tied changed places for a hundredth of the noise's level."""
    bare = prepare_campaign(noisy.campaign(noisy.white, 1, RATE), effects=())

    def with_colour(factor, *numbers):
        return with_noise(bare, factor * bare.levels, [(Colour(*numbers),) * 2] * 4)

    one, other = with_colour(1.0, 0.3, 0.5), with_colour(louder, neighbours, rho)
    assert alike(one, other) == alike(other, one) == same
