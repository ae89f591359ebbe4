"""What is left with smooth friction and with sharp friction, and which of the two is looked at."""

from types import SimpleNamespace

import numpy as np
import pytest

from tests.standing_in import standing_in
from tp_jax.estimation.fitted import Fit
from tp_jax.gap.choice import LITTLE, SMOOTHING, _may_be_smoothing

SAMPLES = 1000


def fit(removable: float) -> Fit:
    """A fit that leaves so much beyond the noise; four rows more are a state's prior."""
    r = np.zeros((1, SAMPLES + 4))
    r[0, :SAMPLES] = np.sqrt(1.0 + removable / SAMPLES)
    return standing_in(Fit, linearisation=SimpleNamespace(r=r), dof=SAMPLES)


@pytest.mark.parametrize(
    ("left", "after", "answer"),
    [
        (0.9 * LITTLE * SAMPLES, 0.9 * LITTLE * SAMPLES, True),  # little is left
        (1e5, 0.9 * SMOOTHING * 1e5, True),  # sharp friction takes it away
        (1e5, 0.99e5, False),  # the model is wrong elsewhere
    ],
)
def test_when_it_may_be_the_smoothing(left, after, answer):
    assert _may_be_smoothing(fit(left), fit(after)) is answer


def test_nothing_sharper_to_look_at():
    same = fit(0.0)
    assert not _may_be_smoothing(same, same)
