"""The virtual rig as a whole: its numbers, its runs, what it refuses."""

import dataclasses

import numpy as np
import pytest

from tp_jax.errors import InputError
from tp_jax.model import presets
from tp_jax.rig import BENCH, RigParameters, VirtualRig, motion
from tp_jax.rig.stepper import stepper

TS = np.arange(2501) / 250.0


def test_bench_is_that_of_the_presets():
    there = presets.values("bench")
    assert dataclasses.asdict(BENCH) == {name: there[name] for name in dataclasses.asdict(BENCH)}


def test_scaled_stays_within_the_spread():
    for seed in range(20):
        p = BENCH.scaled(np.random.default_rng(seed), 0.5)
        for name, value in dataclasses.asdict(p).items():
            assert 0.5 <= value / getattr(BENCH, name) <= 1.5
    assert p != BENCH


def test_a_rig_without_a_run_stands():
    rig = VirtualRig()
    assert rig.advance(0.0) == (0.0, 0.0)
    assert rig.advance(3.0) == (0.0, 0.0)
    assert rig.amplitude == BENCH.A


def test_amplitude_can_be_set_for_the_next_run():
    rig, there = VirtualRig(), VirtualRig(dataclasses.replace(BENCH, A=0.1))
    rig.amplitude = 0.1
    np.testing.assert_array_equal(rig.run(TS[:251], omega=13.0), there.run(TS[:251], omega=13.0))
    rig.amplitude = -1.0
    with pytest.raises(InputError, match="A must be"):
        rig.start(omega=13.0)


def test_begins_at_its_release():
    rig = VirtualRig()
    rig.start(release=0.4)
    assert rig.advance(0.0) == (0.4, 0.0)
    rig.start(omega=10.0)
    assert rig.advance(0.0) == (0.0, 0.0)


def test_sample_by_sample_is_the_run():
    rig = VirtualRig()
    whole = rig.run(TS, omega=13.09)
    rig.start(omega=13.09)
    np.testing.assert_array_equal(whole, [rig.advance(t) for t in TS.tolist()])
    # the same time once more is no step back
    assert rig.advance(10.0) == tuple(whole[-1])


@pytest.mark.parametrize(
    ("given", "says"),
    [
        (dict(omega=1.0, release=0.1), "not both"),
        (dict(omega=float("nan")), "omega must be a finite number"),
        (dict(release=float("inf")), "release must be a finite number"),
        (dict(duration=0.0), "duration must be above zero"),
    ],
)
def test_runs_that_cannot_be(given, says):
    with pytest.raises(InputError, match=says):
        VirtualRig().start(**given)


def test_time_does_not_run_back():
    rig = VirtualRig()
    rig.start(omega=13.09)
    rig.advance(1.0)
    with pytest.raises(InputError, match="cannot go back"):
        rig.advance(0.999)
    with pytest.raises(InputError, match="finite number"):
        rig.advance(float("nan"))


@pytest.mark.parametrize("given", [dict(B1=0.0), dict(k=-1.0), dict(M1=float("nan"))])
def test_rigs_that_cannot_be(given):
    with pytest.raises(InputError, match=r"The rig's \w+ must be"):
        RigParameters(**given)


def test_effects_of_a_rider_need_one():
    with pytest.raises(InputError, match="needs a rider"):
        VirtualRig(dataclasses.replace(BENCH, B2=0.0), {"contact_wear": 0.1})


def test_is_fast(monkeypatch):
    """Of a run of 10 s, which takes 0.1 s on a free machine, the steps are counted: they are what
    it costs, however busy the machine is.
    """
    steps = []

    def counted(*functions):
        take = stepper(*functions)
        return lambda *state: steps.append(state[0]) or take(*state)

    monkeypatch.setattr(motion, "stepper", counted)
    VirtualRig().run(TS, omega=13.09)
    assert 2000 < len(steps) < 15_000  # 7,000
