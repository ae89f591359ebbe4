"""Noisy measured drives are put right once a cause is in the model that kept them from it."""

import pytest

from tests.estimation.test_drive_errors import campaign
from tp_jax.gap.diagnosis import examine

LATE = 8e-3  # s, of the drive's readings


@pytest.fixture(scope="module")
def found():
    return examine(campaign(late=LATE))


def test_all_that_is_left_is_noise(found):
    """Without the delay all drives had further to go than noise moves them, and stayed wrong."""
    result = found.diagnosis.to_dict()
    assert [cause["effect"] for cause in result["causes"]] == ["drive_delay"]
    assert result["verdict"] == "explained"
    assert result["gap"]["structure_p_after"] > 0.01
    assert sorted(found.setting.drives) == found.setting.fitted


def test_the_delays_interval_has_the_errors_of_the_drives(found):
    low, high = found.diagnosis.to_dict()["causes"][0]["parameters"]["a"]["ci95"]
    assert low < LATE < high
    assert high - low < 0.05 * LATE
