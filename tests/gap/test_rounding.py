"""Scores of readings that are rounded more coarsely than they are noisy."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from tests import noisy
from tests.standing_in import standing_in
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.prepared_campaign import PreparedCampaign, prepare_campaign
from tp_jax.estimation.problem import Problem
from tp_jax.estimation.schedule import fit_over_schedule
from tp_jax.estimation.sharpen import fit_with_sharp_friction
from tp_jax.estimation.start import initial_values
from tp_jax.gap import rounding
from tp_jax.gap.known_noise import with_noise_of
from tp_jax.gap.policy import POLICY
from tp_jax.gap.rounding import Rounding
from tp_jax.gap.screen import screen
from tp_jax.gap.structure import structure_test

STEP, NOISE, SAMPLES = 6e-3, 3e-4, 50
LEVEL = float(np.hypot(NOISE, STEP / np.sqrt(12.0)))


def drawn(step, count=400):
    """Scores (3, count) of three windows with the same motion, two of them of one recording."""
    predicted = np.zeros((3, SAMPLES, 2))
    predicted[:, :, 0] = 0.01 * np.sin(np.linspace(0.0, 3.0, SAMPLES))
    columns = np.zeros((3, 2 * SAMPLES + 4, 1), dtype=np.float32)
    columns[:, : 2 * SAMPLES : 2, 0] = 1.0
    problem = standing_in(
        Problem,
        sigma=np.full((3, 2), LEVEL),
        whiten=lambda r: None,
        windows=SimpleNamespace(recording=np.array([0, 0, 1])),
    )
    steps = np.tile([step, 0.0], (3, 1))
    source = Rounding(problem, predicted, steps, columns, np.arange(3))
    return source.scores(np.random.default_rng(0), count)[:, 0]


def test_the_same_motion_has_the_same_error_again():
    found = np.corrcoef(drawn(STEP))
    assert found[0, 1] > 0.8
    assert abs(found[0, 2]) < 0.2  # where the steps lie in another recording is another matter


def test_without_steps_it_is_noise():
    scores = drawn(0.0)
    np.testing.assert_allclose(scores.std(axis=1), np.sqrt(SAMPLES), rtol=0.15)
    assert np.abs(np.corrcoef(scores) - np.eye(3)).max() < 0.2


def drawn_at(rest, step):
    """Mean squares of drawn readings of a body at rest."""
    predicted = np.zeros((3, SAMPLES, 2))
    predicted[:, :, 0] = rest
    problem = standing_in(
        Problem,
        sigma=np.full((3, 2), LEVEL),
        whiten=lambda r: None,
        windows=SimpleNamespace(recording=np.array([0, 1, 2]), n=3),
    )
    lin = SimpleNamespace(
        r=np.zeros((3, 2 * SAMPLES + 4)),
        valid=np.ones((3, 2 * SAMPLES + 4), dtype=bool),
        states_jac=np.zeros((3, 2 * SAMPLES + 4, 4)),
    )
    fit = standing_in(Fit, problem=problem, linearisation=lin, dof=6 * SAMPLES)
    steps = np.tile([step, 0.0], (3, 1))
    source = Rounding(problem, predicted, steps, np.zeros((3, 1, 0)), np.zeros(3, dtype=int))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rounding, "coarse_steps", lambda setting: steps)
        patch.setattr(rounding, "rounding", lambda *args: source)
        return rounding.drawn_squares(fit, standing_in(PreparedCampaign), 200)


def test_a_body_at_rest_reads_with_an_error_that_its_place_on_a_step_decides():
    """So that its sum of squares scatters by far more than that of so many samples of noise."""
    found = drawn_at(0.01, STEP)
    assert found.mean() == pytest.approx(1.0, abs=0.1)
    assert found.std() > 3.0 * np.sqrt(2.0 / (6 * SAMPLES))
    assert drawn_at(0.01, 0.0).size == 0


def encoder(rng, y, run):
    """An encoder of ten bits, whose steps are twenty times the noise."""
    return noisy.rounded(y + NOISE * rng.standard_normal(y.shape), 10)


@pytest.mark.slow
def test_an_encoder_is_no_structure():
    setting = prepare_campaign(noisy.campaign(encoder, 1, (100.0,) * 4))
    fit = fit_over_schedule(setting, initial_values(setting), setting.unknowns())
    setting, fit = with_noise_of(setting, fit, fit)
    seen = screen(fit_with_sharp_friction(setting, fit), setting, states=False)
    assert seen.rounding is not None
    assert structure_test(seen, seed=0).p > POLICY.structure.seen
    # an effect that is plain is seen all the same
    strong = [
        dataclasses.replace(s, blocks=s.blocks + 30.0 * np.sqrt(np.diag(s.V)) / len(s.blocks))
        for s in seen.scored
    ]
    plain = dataclasses.replace(seen, scored=tuple(strong))
    assert structure_test(plain, seed=0).p < POLICY.structure.seen
