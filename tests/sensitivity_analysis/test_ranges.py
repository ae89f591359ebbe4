"""Where a global analysis looks."""

import numpy as np
import pytest

from tests.reference import BENCH
from tp_jax.sensitivity_analysis.ranges import ranges


def test_by_a_factor_down_and_up():
    (k,) = ranges({"k": 0.45}, ["k"], 1.2e-3, 1.5)
    assert (k.low, k.high) == pytest.approx((0.3, 0.675))
    np.testing.assert_allclose(k.at(np.array([0.0, 0.5, 1.0])), [0.3, 0.45, 0.675])


def test_ts2_gets_all_of_the_contacts_friction():
    values = {**BENCH, "Ts2": 0.0}
    (found,) = ranges(values, ["Ts2"], 1.2e-3)
    assert found.low == 0.0
    assert found.high == pytest.approx(BENCH["Ts1"] + BENCH["Tst"])
    assert found.at(np.array([0.5]))[0] == pytest.approx(0.5 * found.high)


def test_what_is_zero_runs_to_its_typical_size():
    (found,) = ranges({"Tv": 0.0}, ["Tv"], 2e-3)
    assert (found.low, found.high) == (0.0, pytest.approx(2e-3))


def test_a_negative_gain():
    (found,) = ranges({"gain": -2.0}, ["gain"], 1.0, 2.0)
    values = found.at(np.linspace(0.0, 1.0, 5))
    assert (np.diff(values) > 0.0).all()
    np.testing.assert_allclose(values[[0, -1]], [-4.0, -1.0])


def test_no_spread_is_refused():
    with pytest.raises(ValueError, match="above 1"):
        ranges({"k": 1.0}, ["k"], 1.0, 1.0)
