"""Demands on any effect that can be hidden: nothing at zero, its own channel, an end."""

import functools
from collections.abc import Callable, Iterable

import numpy as np

from tp_jax.effects import CHANNELS
from tp_jax.rig import BENCH, VirtualRig
from tp_jax.rig.effects import Effect, catalogue

TS = np.arange(501) / 250.0
OMEGA = 17.0

#: What no reading of an angle shows: tests/effects/test_drive_delay.py
UNSEEN = {"drive_delay"}


@functools.cache
def without(omega: float | None = OMEGA) -> np.ndarray:
    return readings_of(VirtualRig(), omega)


def readings_of(rig: VirtualRig, omega: float | None = OMEGA, **given) -> np.ndarray:
    kind = {"release": 0.6} if omega is None else {"omega": omega}
    return rig.run(TS, **kind, **given)


def drawn(effect: Effect, seed: int = 0, scale: float = 1.0) -> VirtualRig:
    """The bench with an effect of a size it might have, times `scale`."""
    draw = effect.draw(np.random.default_rng(seed))
    sizes = tuple(scale * size for size in draw.sizes)
    return VirtualRig(effects={effect.id: sizes}, shapes=draw.shapes, seed=seed)


def rms(a) -> np.ndarray:
    return np.sqrt(np.mean(a**2, axis=0))


def says_what_it_is(id):
    effect = catalogue()[id]
    assert effect.id == id
    assert effect.formula
    assert effect.__doc__
    assert len(effect.unit) == len(effect.amplitudes)
    assert CHANNELS[effect.location] == effect.channel
    draw = effect.draw(np.random.default_rng(0))
    assert len(draw.sizes) == len(effect.amplitudes)
    assert all(np.isfinite(draw.sizes))
    assert any(draw.sizes)
    assert set(draw.shapes) <= {f"{id}.{name}" for name in effect.shapes}


def size_zero_changes_nothing(id):
    np.testing.assert_array_equal(readings_of(drawn(catalogue()[id], scale=0.0)), without())


def next_to_no_size_changes_next_to_nothing(id):
    # switched on at all, the effect's code runs; what it adds is next to nothing
    y = readings_of(drawn(catalogue()[id], scale=1e-9))
    np.testing.assert_allclose(y, without(), rtol=0.0, atol=1e-7)


def acts_through_its_channel(id):
    effect = catalogue()[id]
    rig, bare, still = drawn(effect), VirtualRig(), drawn(effect)
    ts = TS[:251].tolist()
    for each in (rig, bare, still):
        each.start(omega=OMEGA, duration=1.0)
    stamps = [rig.true_time(t) for t in ts]
    read = np.array([rig.advance(t) for t in stamps])
    moved, rest = (np.array([each.motion(t) for t in ts]) for each in (still, bare))
    if effect.channel in ("column", "contact"):
        # bodies move otherwise, sensors report what is; the clock is right
        assert rms(moved - rest)[:2].max() > 1e-5
        np.testing.assert_array_equal(read, moved[:, :2])
        assert stamps == ts
        return
    np.testing.assert_allclose(moved, rest, rtol=0.0, atol=1e-8)
    changed = rms(read - rest[:, :2])
    if id in UNSEEN:
        assert not changed.any()
        return
    if effect.channel == "clock":
        assert changed[1] > 1e-4
        assert id == "channel_delay" or changed[0] > 1e-4
        return
    own = int(effect.channel == "sensor2")
    assert changed[own] > 1e-3
    assert changed[1 - own] < 1e-8
    assert stamps == ts


def is_the_same_again_with_the_same_seed(id):
    ts = TS[:151]
    one, two, other = drawn(catalogue()[id]), drawn(catalogue()[id]), drawn(catalogue()[id], seed=1)
    first = one.run(ts, omega=OMEGA)
    np.testing.assert_array_equal(first, two.run(ts, omega=OMEGA))
    assert not np.array_equal(first, other.run(ts, omega=OMEGA)) or id in UNSEEN | {"drive_steps"}
    # and so is the second run, which chance may make another
    np.testing.assert_array_equal(one.run(ts, omega=OMEGA), two.run(ts, omega=OMEGA))


def takes_its_time_but_ends(id):
    # decays too, and rigs of other sizes
    rng = np.random.default_rng(7)
    p = BENCH.scaled(rng, 0.5)
    draw = catalogue()[id].draw(rng, p)
    for omega in (None, p.natural_frequency):
        rig = VirtualRig(p, {id: draw.sizes}, shapes=draw.shapes)
        assert np.isfinite(readings_of(rig, omega)).all()
        assert rig.switches < 250
        assert rig.steps < 10_000


def any_two_effects_on_any_rig(ids, seed):
    rng = np.random.default_rng(seed)
    p = BENCH.scaled(rng, 0.5)
    pair = rng.choice(list(ids), 2, replace=False)
    draws = {id: catalogue()[id].draw(rng, p) for id in pair.tolist()}
    rig = VirtualRig(
        p,
        {id: draw.sizes for id, draw in draws.items()},
        seed=seed,
        shapes={name: value for draw in draws.values() for name, value in draw.shapes.items()},
    )
    y = rig.run(TS[:251], omega=p.natural_frequency)
    assert np.isfinite(y).all()
    assert rig.switches < 150


DEMANDS: tuple[Callable[[str], None], ...] = (
    says_what_it_is,
    size_zero_changes_nothing,
    next_to_no_size_changes_next_to_nothing,
    acts_through_its_channel,
    is_the_same_again_with_the_same_seed,
    takes_its_time_but_ends,
)

#: A filter of no time constant, or a base of infinite inertia, is stiff.
STIFF = {"sensor2_lag", "base_compliance"}


def demands(ids: Iterable[str]) -> list[tuple[Callable[[str], None], str]]:
    """Every demand on every effect of these."""
    return [
        (demand, id)
        for demand in DEMANDS
        for id in ids
        if demand is not next_to_no_size_changes_next_to_nothing or id not in STIFF
    ]
