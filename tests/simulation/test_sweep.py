"""Sweeps: each member as `simulate` finds it, in its place, however many there are."""

import importlib

import jax
import numpy as np
import pytest

from tests.reference import BENCH, reference
from tp_jax.effects import Applied, catalogue
from tp_jax.model import presets
from tp_jax.simulation import simulate, sweep

module = importlib.import_module("tp_jax.simulation.sweep")  # the function has its name

TS = np.linspace(0.0, 0.2, 21)
SLIDING = np.array([0.1, 0.0, 8.0, -12.0])


def several(n):
    """Pendulums that differ in two numbers and share the rest."""
    of = lambda k, B2: presets.double_pendulum(**BENCH | {"k": k, "B2": B2})  # noqa: E731
    many = jax.vmap(of, out_axes=0)(np.linspace(0.3, 0.6, n), np.linspace(4e-4, 6e-4, n))
    return many


def shared(n):
    """The same with numbers of no axis where the members agree."""
    model = presets.double_pendulum(**BENCH | {"k": np.linspace(0.3, 0.6, n)})
    return model, model.spring.k


@pytest.fixture
def traces(monkeypatch):
    """How often the engine is traced."""
    count = []

    def counted(*args, **more):
        count.append(1)
        return integrate(*args, **more)

    integrate = module.integrate
    monkeypatch.setattr(module, "integrate", counted)
    return count


@pytest.fixture(scope="module")
def five():
    return sweep(several(5), TS, SLIDING, tolerance=1e-8)


def test_shapes_and_types(five):
    for name in ("phi1", "phi2", "omega1", "omega2"):
        assert getattr(five, name).shape == (5, 21)
    np.testing.assert_array_equal(five.t, TS)
    assert five.steps.shape == (5,)
    assert five.complete.tolist() == [True] * 5
    assert (five.steps > 20).all()


def test_members_are_those_of_simulate(five):
    k, B2 = np.linspace(0.3, 0.6, 5), np.linspace(4e-4, 6e-4, 5)
    for i in range(5):
        values = BENCH | {"k": k[i], "B2": B2[i]}
        one = simulate(presets.double_pendulum(**values), TS, SLIDING, tolerance=1e-8)
        for name in ("phi1", "phi2", "omega1", "omega2"):
            np.testing.assert_allclose(getattr(five, name)[i], getattr(one, name), atol=1e-9)
    expected = reference(values, TS, SLIDING, rtol=1e-12, atol=1e-13)  # the last one
    np.testing.assert_allclose(five.phi1[4], expected[:, 0], rtol=0.0, atol=5e-8)
    np.testing.assert_allclose(five.phi2[4], expected[:, 1], rtol=0.0, atol=5e-8)


def test_numbers_that_all_share(five):
    model, k = shared(5)
    found = sweep(model, TS, SLIDING, tolerance=1e-8)
    for i in (0, 4):
        expected = reference(BENCH | {"k": k[i]}, TS, SLIDING, rtol=1e-12, atol=1e-13)
        np.testing.assert_allclose(found.phi2[i], expected[:, 1], rtol=0.0, atol=5e-8)


def test_rounding_up_changes_nothing(five, traces):
    # 5, 6 and 8 members are one program, and a member is the same whoever is beside it
    model = several(5)
    six = jax.tree.map(lambda x: np.concatenate([x, x[:1]]) if x.ndim else x, model)
    eight = jax.tree.map(lambda x: np.concatenate([x, x[:3]]) if x.ndim else x, model)
    for n, more in ((6, six), (8, eight)):
        found = sweep(more, TS, SLIDING, tolerance=1e-8)
        assert found.phi1.shape == (n, 21)
        for name in ("phi1", "phi2", "omega1", "omega2", "steps"):
            np.testing.assert_array_equal(getattr(found, name)[:5], getattr(five, name))
            np.testing.assert_array_equal(getattr(found, name)[5:], getattr(five, name)[: n - 5])
    assert not traces


def test_numbers_times_and_bounds_are_data(five, traces):
    found = sweep(several(5), 2.0 * TS + 0.1, -SLIDING, tolerance=1e-5, max_steps=10_000)
    assert found.complete.all()
    assert (found.steps != five.steps).all()
    assert not traces


def test_starts_of_ones_own(five):
    starts = SLIDING * np.linspace(0.5, 1.5, 5)[:, None]
    found = sweep(several(5), TS, starts, tolerance=1e-8)
    np.testing.assert_array_equal(found.phi1[:, 0], starts[:, 0])
    np.testing.assert_array_equal(found.omega2[:, 0], starts[:, 3])
    np.testing.assert_allclose(found.phi2[2], five.phi2[2], rtol=0.0, atol=1e-12)  # the middle one
    # one pendulum from several starts
    k, B2 = np.linspace(0.3, 0.6, 5)[4], np.linspace(4e-4, 6e-4, 5)[4]
    one = presets.double_pendulum(**BENCH | {"k": k, "B2": B2})
    alone = sweep(one, TS, starts, tolerance=1e-8)
    np.testing.assert_allclose(alone.phi2[4], found.phi2[4], rtol=0.0, atol=1e-12)
    # and one from rest, which is a sweep of one
    rest = sweep(several(5), TS, tolerance=1e-8)
    assert (rest.phi1[:, 0] == 0.0).all()
    assert (rest.omega2[:, 0] == 0.0).all()


def test_a_member_that_fails_is_marked(five):
    model, _ = shared(5)
    k = np.array(model.spring.k)
    k[[1, 4]] = np.nan
    found = sweep(presets.double_pendulum(**BENCH | {"k": k}), TS, SLIDING, tolerance=1e-8)
    assert found.complete.tolist() == [True, False, True, True, False]
    assert (found.phi1[[1, 4], 1:] == np.inf).all()
    assert np.isfinite(found.phi1[[0, 2, 3]]).all()


def test_angles_alone(five):
    found = sweep(several(5), TS, SLIDING, tolerance=1e-8, velocities=False)
    assert found.omega1 is None
    assert found.omega2 is None
    np.testing.assert_allclose(found.phi1, five.phi1, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(found.phi2, five.phi2, rtol=0.0, atol=1e-12)
    np.testing.assert_array_equal(found.steps, five.steps)


def test_threads_keep_the_order(traces):
    # more members than fill the lanes of one thread: some queue, some go to another
    n = 2 * module.WIDTH + 5
    model, k = shared(n)
    alone = sweep(model, TS, SLIDING, threads=1, velocities=False)
    assert (np.diff(alone.phi1[:, -1]) != 0.0).all()
    assert alone.complete.all()
    found = sweep(model, TS, SLIDING, threads=3, velocities=False)
    np.testing.assert_allclose(found.phi1, alone.phi1, rtol=0.0, atol=1e-12)
    np.testing.assert_array_equal(found.steps, alone.steps)
    assert found.complete.all()
    assert len(traces) == 2  # one program for all shares
    for i in (1, n - 1):
        expected = reference(BENCH | {"k": k[i]}, TS, SLIDING)
        np.testing.assert_allclose(found.phi1[i], expected[:, 0], rtol=0.0, atol=1e-5)


def test_effects_vary_too():
    effect = catalogue()["spring_asymmetry"]
    a = np.array([0.0, 0.2])
    model = presets.double_pendulum(**BENCH, terms=(Applied(effect, {"a": a}),))
    found = sweep(model, TS, SLIDING, tolerance=1e-8)
    for i in range(2):
        expected = reference(BENCH, TS, SLIDING, "spring_asymmetry", {"a": a[i]})
        np.testing.assert_allclose(found.phi1[i], expected[:, 0], rtol=0.0, atol=1e-7)


@pytest.mark.parametrize(
    ("model", "ts", "y0", "said"),
    [
        (several(3), TS, np.zeros((4, 4)), "equally many, but there are .3, 4."),
        (several(3), TS, np.zeros(5), "`y0` must have shape .4,. or .N, 4., but has .5,."),
        (several(3), TS, np.zeros((3, 5)), "`y0` must have shape"),
        (several(3), TS, np.zeros((1, 3, 4)), "`y0` must have shape"),
        pytest.param(several(3), TS, 0.0, "`y0` must have shape", marks=pytest.mark.unchecked),
        pytest.param(
            several(3),
            1.0,
            None,
            "`ts` must hold at least two times",
            marks=pytest.mark.unchecked,
        ),
        (several(3), TS[::-1], None, "`ts` must increase"),
        (several(3), TS[[0, 1, 1]], None, "`ts` must increase"),
        (
            presets.double_pendulum(**BENCH | {"k": np.ones(3), "B2": np.ones(2)}),
            TS,
            None,
            "equally many, but there are .2, 3.",
        ),
        (
            presets.double_pendulum(**BENCH | {"k": np.ones((3, 2))}),
            TS,
            None,
            "spring.k has shape .3, 2.",
        ),
        (
            presets.double_pendulum(**BENCH | {"k": np.ones(0)}),
            TS,
            None,
            "at least one pendulum",
        ),
    ],
)
def test_what_does_not_fit(model, ts, y0, said):
    with pytest.raises(ValueError, match=said) as raised:
        sweep(model, ts, y0)
    text = str(raised.value)
    assert text.endswith(".")
    assert "\n" not in text
    assert len(text) < 150
