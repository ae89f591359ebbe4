"""Sentences beside the numbers."""

from types import SimpleNamespace

import numpy as np
import pytest

from tests.standing_in import standing_in
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.gap.notes import _drive_noise
from tp_jax.gap.policy import POLICY

T = np.arange(2000) / 200.0


def recording(noise, measured=True):
    drive = 0.4 * np.sin(6.0 * T) + 0.4 * noise * np.random.default_rng(0).standard_normal(T.size)
    return SimpleNamespace(t=T, drive=drive, measured_drive=measured)


@pytest.mark.parametrize("noise", [2e-2, 2e-3, 1e-4])
def test_the_noise_of_a_measured_drive_is_a_part_of_its_amplitude(noise):
    still = SimpleNamespace(t=T, drive=np.full(T.size, 0.1), measured_drive=True)
    found = _drive_noise(standing_in(PreparedCampaign, recordings=[recording(noise), still]))
    assert found == pytest.approx(noise, rel=0.2)
    assert (found > POLICY.noise.drive) == (noise > 1e-3)


def test_a_commanded_drive_has_none():
    setting = standing_in(PreparedCampaign, recordings=[recording(0.1, measured=False)])
    assert _drive_noise(setting) == 0.0
