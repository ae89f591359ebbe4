"""Angles beyond the range of one reading."""

import numpy as np
import pytest

from tp_jax.recordings.unwrap import Unwrapper

T = np.arange(0.0, 4.0, 1e-3)


def followed(law, principal, t=T, size=17):
    unwrapper = Unwrapper(law)
    parts = [
        unwrapper.feed(t[i : i + size], principal[i : i + size]) for i in range(0, t.size, size)
    ]
    return np.concatenate(parts), unwrapper


def two_bridges(angle, noise=1e-3):
    rng = np.random.default_rng(0)
    sine, cosine = np.sin(2 * angle), np.cos(2 * angle)
    n1, n2 = 2 * noise * rng.normal(size=(2, angle.size))
    return 0.5 * np.arctan2(sine + n1, cosine + n2)


def one_bridge(angle, noise=1e-3):
    rng = np.random.default_rng(0)
    volts = 0.5 * np.sin(2 * angle) + noise * rng.normal(size=angle.size)
    return 0.5 * np.arcsin(np.clip(2 * volts, -1.0, 1.0))


def test_a_ring_that_winds():
    angle = 12.0 * T + np.sin(7 * T)
    got, unwrapper = followed("sine_cosine", two_bridges(angle))
    np.testing.assert_allclose(got, angle, atol=6e-3)
    assert unwrapper.uncertain == []


def test_lost_samples_do_not_matter_but_a_long_gap_is_doubtful():
    angle = 12.0 * T
    keep = np.random.default_rng(1).random(T.size) > 0.3
    got, unwrapper = followed("sine_cosine", two_bridges(angle)[keep], T[keep])
    np.testing.assert_allclose(got, angle[keep], atol=6e-3)
    assert unwrapper.uncertain == []
    keep = (T < 1.0) | (T > 1.3)
    got, unwrapper = followed("sine_cosine", two_bridges(angle)[keep], T[keep])
    assert unwrapper.uncertain == [pytest.approx(1.301)]
    off = (got - angle[keep]) / np.pi  # whole turns of the sensor, from there on
    np.testing.assert_allclose(off, np.rint(off), atol=2e-3)


def test_a_column_after_a_gap_is_where_its_spring_holds_it():
    angle = 0.9 * np.sin(2.0 * T)
    keep = (T < 0.8) | (T > 2.3)  # from one side to the other
    unwrapper = Unwrapper("sine_cosine", winds=False)
    got = unwrapper.feed(T[keep], two_bridges(angle)[keep])
    np.testing.assert_allclose(got, angle[keep], atol=6e-3)
    assert unwrapper.uncertain == []


def test_a_gap_at_rest_is_not_doubtful():
    keep = (T < 1.0) | (T > 1.3)
    got, unwrapper = followed("sine_cosine", two_bridges(np.full(T.size, 2.0))[keep], T[keep])
    assert unwrapper.uncertain == []
    assert np.ptp(got) < 0.01


@pytest.mark.parametrize("amplitude", [0.5, 1.0, 1.2, 1.4, 2.5])
def test_one_bridge_beyond_its_fold(amplitude):
    angle = amplitude * np.sin(13.0 * T)
    got, unwrapper = followed("sine", one_bridge(angle))
    # at the fold itself a bridge tells little
    np.testing.assert_allclose(got, angle, atol=0.08 if amplitude > 0.7 else 0.01)
    assert unwrapper.uncertain == []


def test_turning_round_at_the_fold_is_doubtful():
    _, unwrapper = followed("sine", one_bridge(0.78 * np.sin(5.0 * T)))
    assert len(unwrapper.uncertain) >= 5


def test_a_line_is_left_alone():
    got, _ = followed("line", 3.0 * T)
    np.testing.assert_array_equal(got, 3.0 * T)
    assert Unwrapper("sine").feed(T[:0], T[:0]).size == 0
