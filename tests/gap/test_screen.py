"""What an effect is predicted to gain, within the bounds of its amplitudes."""

import numpy as np
import pytest

from tp_jax.effects import catalogue
from tp_jax.gap.screen import predicted_drop


def limits(id):
    return np.array([(a.lower, a.upper) for a in catalogue()[id].amplitudes])


@pytest.mark.parametrize(
    ("score", "estimate", "drop"),
    [(-2.0, 0.5, 1.0), (3.0, 0.0, 0.0), (-8.0, 1.0, 12.0)],  # within 0 to 1, below, beyond
)
def test_a_friction_gives_way_by_no_negative_part(score, estimate, drop):
    found, gain, free = predicted_drop(
        limits("contact_presliding"), np.array([[4.0]]), np.array([score])
    )
    np.testing.assert_allclose(found, [estimate], atol=1e-12)
    assert gain == pytest.approx(drop, abs=1e-9)
    assert free == pytest.approx(score**2 / 4.0)


def test_what_a_bound_stops_another_amplitude_makes_up_for():
    """Of two, in the metric of V: the best point on the edge, not the nearest corner."""
    V, score = np.array([[4.0, 1.0], [1.0, 2.0]]), np.array([-8.0, 0.0])
    found, gain, free = predicted_drop(limits("contact_position"), V, score)
    np.testing.assert_allclose(found, [1.0, -0.5])
    assert gain == pytest.approx(-(2.0 * score @ found + found @ V @ found))
    assert gain < free
    within, *_ = predicted_drop(limits("spring_asymmetry"), V[:1, :1], score[:1])
    np.testing.assert_allclose(within, [2.0])  # has no bounds


def test_what_the_data_do_not_know_stays_at_null():
    """Or rounding would send it to a bound."""
    V, score = np.diag([4.0, 1e-30]), np.array([-8.0, 1e-20])
    found, gain, _ = predicted_drop(limits("contact_position"), V, score)
    np.testing.assert_allclose(found, [1.0, 0.0])
    assert gain == pytest.approx(12.0)
