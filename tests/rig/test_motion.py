"""Motions whose course is known exactly."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from tests.rig.events import by_events, consistent
from tp_jax.rig import BENCH, RigParameters, VirtualRig
from tp_jax.rig.equations import equations
from tp_jax.rig.hooks import Hooks, Instant
from tp_jax.rig.motion import Motion

TS = np.arange(2501) / 250.0
SINGLE = dataclasses.replace(BENCH, B2=0.0)


def energy(p: RigParameters, phi1, phi2, v1, v2) -> float:
    return 0.5 * (p.B1 * v1**2 + p.B2 * (v1 + v2) ** 2 + p.k * phi1**2)


def test_free_oscillation_without_friction():
    p = dataclasses.replace(SINGLE, c1=0.0, M1=0.0)
    y = VirtualRig(p).run(TS, release=0.7)
    np.testing.assert_allclose(y[:, 0], 0.7 * np.cos(p.natural_frequency * TS), rtol=0.0, atol=1e-9)
    np.testing.assert_array_equal(y[:, 1], 0.0)


def test_damped_oscillation():
    p = dataclasses.replace(SINGLE, M1=0.0)
    w, d = p.natural_frequency, 0.5 * p.c1 / p.B1
    wd = np.sqrt(w**2 - d**2)
    exact = 0.7 * np.exp(-d * TS) * (np.cos(wd * TS) + d / wd * np.sin(wd * TS))
    np.testing.assert_allclose(VirtualRig(p).run(TS, release=0.7)[:, 0], exact, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("release", [0.7, -0.431, 0.05])
def test_coulomb_decay(release):
    # half swings of the frequency about +-M1/k, each smaller than the last by 2 M1/k, then rest
    p = dataclasses.replace(SINGLE, c1=0.0)
    w, shift = p.natural_frequency, p.M1 / p.k
    exact, start, t0 = np.empty_like(TS), release, 0.0
    while abs(start) > shift:
        center = np.sign(start) * shift
        here = TS >= t0
        exact[here] = center + (start - center) * np.cos(w * (TS[here] - t0))
        t0, start = t0 + np.pi / w, 2.0 * center - start
    exact[TS >= t0] = start
    rig = VirtualRig(p)
    y = rig.run(TS, release=release)[:, 0]
    np.testing.assert_allclose(y, exact, rtol=0.0, atol=1e-9)
    # rest is rest
    assert rig.motion(10.0)[2] == 0.0
    assert np.unique(y[TS > t0 + 1e-6]).size == 1


def test_too_weak_a_pull_moves_nothing():
    rig = VirtualRig()
    y = rig.run(TS, release=0.99 * BENCH.M1 / BENCH.k)
    assert (y[:, 0] == y[0, 0]).all()
    assert (y[:, 1] == 0.0).all()
    assert rig.switches == 0


def test_starts_when_the_spring_overcomes_friction():
    rig = VirtualRig()
    rig.start(omega=6.0)
    starts = np.arcsin(BENCH.M1 / (BENCH.k * BENCH.A)) / 6.0
    assert rig.motion(starts - 1e-6)[0] == 0.0
    assert 0.0 < rig.motion(starts + 1e-3)[0] < 1e-6


def test_stuck_pair_moves_as_one_body():
    glued = dataclasses.replace(BENCH, Ts1=1.0)
    one = dataclasses.replace(SINGLE, B1=BENCH.B1 + BENCH.B2)
    for kind in ({"omega": 13.09}, {"release": 0.6}):
        pair, single = VirtualRig(glued).run(TS, **kind), VirtualRig(one).run(TS, **kind)
        assert (pair[:, 1] == 0.0).all()
        np.testing.assert_allclose(pair[:, 0], single[:, 0], rtol=0.0, atol=1e-9)


def test_rider_without_friction_stays_where_it_is():
    p = dataclasses.replace(BENCH, Ts1=0.0, Tst=0.0, Tv=0.0)
    y = VirtualRig(p).run(TS, omega=13.09)
    np.testing.assert_allclose(y.sum(axis=1), 0.0, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(
        y[:, 0], VirtualRig(SINGLE).run(TS, omega=13.09)[:, 0], rtol=0.0, atol=1e-9
    )


@pytest.mark.parametrize("kind", [{"omega": 13.09}, {"omega": 17.0}, {"release": 0.6}])
def test_agrees_with_scipy_from_switch_to_switch(kind):
    ts = np.arange(501) / 250.0
    np.testing.assert_allclose(
        VirtualRig().run(ts, **kind), by_events(BENCH, ts, **kind), rtol=0.0, atol=1e-9
    )


def test_what_is_read_does_not_depend_on_when_it_is_read():
    often, rarely = VirtualRig(), VirtualRig()
    fine = often.run(np.arange(20_001) / 5000.0, omega=17.0)
    coarse = rarely.run(np.arange(401) / 100.0, omega=17.0)
    np.testing.assert_array_equal(fine[::50], coarse)


@given(st.integers(0, 10**6))
def test_energy_never_grows_undriven(seed):
    rng = np.random.default_rng(seed)
    p = BENCH.scaled(rng, 0.5)
    rig = VirtualRig(p)
    rig.start(release=float(rng.uniform(-1.0, 1.0)))
    E = np.array([energy(p, *rig.motion(t)) for t in np.arange(0.0, 1.0, 0.002).tolist()])
    assert (np.diff(E) <= 1e-10 * E[0]).all()
    assert E[-1] < E[0] or rig.switches == 0


@given(st.integers(0, 10**6), st.sampled_from([0.0, 1e-3, 1.0]))
def test_exactly_one_mode_is_consistent_and_is_chosen(seed, reach):
    # release angles about, and far beyond, those at which column and rider let go
    rng = np.random.default_rng(seed)
    p = BENCH.scaled(rng, 0.5)
    lets_go = p.M1 / p.k if rng.random() < 0.5 else (p.M1 + p.Ts1 * (1 + p.B1 / p.B2)) / p.k
    release = float(rng.choice([-1.0, 1.0]) * lets_go * (1.0 + reach * rng.uniform(-1.0, 1.0)))
    release *= 1.0 + 1e-5 * (reach == 0.0)
    there = consistent(p, None, 0.0, np.array([release, 0.0, 0.0, 0.0]))
    motion = Motion(p, Hooks(), lambda t: 0.0, release)
    assert [(motion.side1, motion.side2)] == there


def stop(motion: Motion) -> tuple[float, float]:
    """When column and rider, both sliding, first come to a stop."""
    stops = [0.0, 0.0]
    while 0.0 in stops:
        motion.step()
        for i, v in enumerate((motion.v1, motion.v2)):
            if v == 0.0 and not stops[i]:
                stops[i] = motion.t
    return stops[0], stops[1]


@pytest.mark.parametrize("v1", [1.0, 0.8, -1.2])
def test_two_bodies_that_stop_at_the_same_instant(v1):
    # the rider's velocity is tuned until both reach zero together
    def thrown(v2):
        return Motion(BENCH, Hooks(), lambda t: 0.0, 0.0, v1=v1, v2=v2)

    def gap(v2):
        one, two = stop(thrown(v2))
        return one - two

    common = brentq(gap, 0.05 * v1, 3.0 * v1, xtol=1e-16, rtol=1e-15)
    assert abs(gap(common)) < 1e-12
    ends = []
    for factor in (1.0 - 1e-10, 1.0, 1.0 + 1e-10):
        motion = thrown(common * factor)
        while motion.t < 2.0:
            segment = motion.step()
        ends.append(segment.read(2.0))
        assert motion.switches < 40
    np.testing.assert_allclose(ends[0], ends[1], rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(ends[2], ends[1], rtol=0.0, atol=1e-8)


def test_two_hundred_rigs_run_without_chatter():
    rng = np.random.default_rng(0)
    ts = np.arange(501) / 250.0
    for _ in range(200):
        p = BENCH.scaled(rng, 0.5)
        rig = VirtualRig(p)
        omega = p.natural_frequency * float(rng.uniform(0.3, 1.5))
        y = rig.run(ts, omega=omega)
        assert np.isfinite(y).all()
        # at most: both bodies stop and start again in every half swing of drive and column
        assert rig.switches <= 8 * 2.0 * (omega + p.natural_frequency) / (2.0 * np.pi)


def test_a_step_on_trial_far_past_a_stop_is_a_number():
    """Seen on a rig with T0 = 900 s/rad: the simulator ended in an OverflowError."""
    p = dataclasses.replace(BENCH, T0=900.0)
    rates, _, limit = equations(p, Hooks(), Instant(), lambda t: 0.0, 1.0)
    assert math.isfinite(limit(1.0, -10.0, False))
    assert all(map(math.isfinite, rates(0.0, 0.0, 0.0, 0.0, -10.0, [], 1.0, 1.0)))
