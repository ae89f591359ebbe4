"""Starts of a multi-start search."""

import dataclasses

import numpy as np
import pytest

from tests.reference import BENCH
from tests.rigs import synthetic_campaign
from tp_jax.errors import InputError
from tp_jax.estimation.prepared_campaign import prepare_campaign
from tp_jax.estimation.start import start_from_data
from tp_jax.estimation.starts import SAMPLINGS, Axis, axes, points, starts
from tp_jax.model.parameters import BY_NAME
from tp_jax.recordings import Recording


@pytest.fixture(scope="module")
def setting():
    return prepare_campaign(synthetic_campaign(duration=2.0), effects=())


@pytest.mark.parametrize("sampling", SAMPLINGS)
def test_points_fill_the_bounds(setting, sampling):
    x = points(setting, 64, seed=0, sampling=sampling)
    for column, axis in zip(x.T, axes(setting), strict=True):
        assert (column >= axis.lower).all()
        assert (column <= axis.upper).all()
        ends = axis.at(np.array([0.1, 0.9]))
        assert column.min() < ends[0] < ends[1] < column.max()
    # one point in each of 64 slices of every axis, or nearly
    k = axes(setting)[1]
    share = np.log(x[:, 1] / k.lower) / np.log(k.upper / k.lower)
    assert k.name == "k"
    assert len(set((share * 64).astype(int))) > 60
    np.testing.assert_array_equal(x, points(setting, 64, seed=0, sampling=sampling))
    assert (x != points(setting, 64, seed=1, sampling=sampling)).all()


def test_more_points_of_sobol_leave_the_first_alone(setting):
    np.testing.assert_array_equal(points(setting, 5, 3), points(setting, 21, 3)[:5])


@pytest.mark.unchecked
def test_another_sampling_is_refused(setting):
    with pytest.raises(InputError, match="no sampling"):
        points(setting, 2, 0, sampling="grid")


def test_ends_of_an_axis():
    for name, bounds in (("k", None), ("k", (0.1, 0.2)), ("M1", None), ("zero1", None)):
        axis = Axis.of(BY_NAME[name], bounds)
        np.testing.assert_allclose(axis.at(np.array([0.0, 1.0])), [axis.lower, axis.upper])
        assert (np.diff(axis.at(np.linspace(0, 1, 9))) > 0.0).all()
    assert Axis.of(BY_NAME["k"], (0.0, 1.0)).lower > 0.0
    assert Axis.of(BY_NAME["M1"], None).kind == "asinh"


def test_the_first_start_is_the_datas_own(setting):
    made = starts(setting, 4, seed=0)
    assert made[0].point is None
    assert made[0].values.get("k") == pytest.approx(BENCH["k"], rel=0.03)
    for start in made[1:]:
        assert start.values.get("T0") == start.point[-3]  # kept: no equation is linear in it
        assert start.values.get("k") == pytest.approx(BENCH["k"], rel=0.1)
    assert len({s.values.get("k") for s in made}) == 4
    alone = starts(setting, 1, seed=9)[0]
    np.testing.assert_array_equal(alone.values.table, made[0].values.table)


@pytest.mark.parametrize(("period", "swing"), [(10.0, 0.06), (60.0, 0.3), (0.5, 1e-3)])
def test_a_slow_or_small_swing_says_what_its_friction_is(period, swing):
    """Its velocities never come near those of the bench; a start far off has no way back."""
    natural, drag = 2.0 * np.pi / period, 0.02 * 2.0 * np.pi / period
    t = np.linspace(0.0, 6.0 * period, 3000)
    phi1 = swing * np.exp(-drag * t) * np.cos(natural * t)
    recording = Recording.from_arrays(t, phi1, name="decay")
    sigma = {"phi1": 1e-3 * swing, "phi2": 1.0}
    found = start_from_data([recording], sigma, np.array([51]), 1.0, {})
    assert found["k"] == pytest.approx(natural**2, rel=0.05)
    assert 0.0 < found["M1"] < 0.1 * found["k"] * swing


def test_raw_starts_are_the_points(setting):
    unknowns = setting.unknowns()
    for start in starts(setting, 4, seed=0, raw=True)[1:]:
        np.testing.assert_array_equal(start.values.pick(unknowns), start.point)


def test_bounds_of_the_user_hold(setting):
    bounded = dataclasses.replace(setting, bounds={"k": (0.5, 0.6), "T0": (2.0, 3.0)})
    for raw in (False, True):
        for start in starts(bounded, 6, raw=raw):
            assert 0.5 <= start.values.get("k") <= 0.6
            assert 2.0 <= start.values.get("T0") <= 3.0
