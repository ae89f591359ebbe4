"""Every effect that can be hidden: nothing at zero, its own channel, the catalogue's formula."""

import functools

import numpy as np
import pytest

from tests.reference import BENCH as NUMBERS
from tests.reference import FORMULAS, readings, reference
from tests.rig.dahl import EFFECTS as WITH_STATES
from tests.rig.dahl import smoothed
from tp_jax.effects import CHANNELS
from tp_jax.effects import catalogue as model_catalogue
from tp_jax.errors import InputError
from tp_jax.rig import BENCH, VirtualRig
from tp_jax.rig.effects import Effect, catalogue

TS = np.arange(501) / 250.0
OMEGA = 17.0
ALL = catalogue()
every_effect = pytest.mark.parametrize("id", list(ALL))

#: The catalogue's ids, which are fixed: results and checks use them.
IDS = {
    "drive_harmonics", "drive_backlash", "drive_frequency", "drive_steps",
    "spring_asymmetry", "spring_hysteresis", "spring_hardening", "spring_relaxation",
    "bearing_stribeck", "bearing_position", "bearing_presliding", "bearing_drag",
    "bearing_warmup", "bearing_asymmetry",
    "contact_stribeck", "contact_position", "contact_presliding", "contact_wear",
    "contact_asymmetry", "contact_vibration", "contact_cogging", "contact_repeatability",
    "column_tilt", "column_cable", "base_compliance",
    "sensor1_nonlinearity", "sensor2_nonlinearity", "sensor1_drift", "sensor2_drift",
    "sensor_crosstalk", "channel_delay", "clock_skew", "reaction_factor",
    "sensor1_eccentricity", "sensor2_eccentricity", "sensor1_interpolation",
    "sensor2_interpolation", "drive_delay", "bearing_load", "spring_deadzone", "elastic_stop",
}  # fmt: skip

#: A modest size where that of the model's catalogue is none.
SIZES = {
    "spring_hysteresis": {"a": 0.1}, "bearing_presliding": {"a": 0.5},
    "contact_presliding": {"a": 0.5}, "column_cable": {"a": 0.05}, "base_compliance": {"a": 0.1},
    "drive_backlash": {"g": 0.01},
}  # fmt: skip

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


def test_the_whole_catalogue_can_be_hidden_and_more():
    inside = {id for id, effect in ALL.items() if effect.in_catalogue}
    assert inside == IDS
    outside = [effect for effect in ALL.values() if not effect.in_catalogue]
    assert len(outside) >= 8
    assert {effect.channel for effect in outside} == set(CHANNELS.values())


@pytest.mark.parametrize("id", sorted(IDS & set(model_catalogue())))
def test_places_and_units_are_those_of_the_model(id):
    here, there = ALL[id], model_catalogue()[id]
    assert (here.location, here.channel) == (there.location, there.channel)
    assert here.amplitudes == tuple(a.name for a in there.amplitudes)
    units = tuple(a.unit for a in there.amplitudes)
    assert here.unit == units
    assert set(here.shapes) == {s.name for s in there.shapes}


@every_effect
def test_says_what_it_is(id):
    effect = ALL[id]
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


@every_effect
def test_size_zero_changes_nothing(id):
    np.testing.assert_array_equal(readings_of(drawn(ALL[id], scale=0.0)), without())


# switched on at all, the effect's code runs; what it adds is next to nothing. A step of the motor
# is not small, and a filter of no time constant, or a base of infinite inertia, is stiff.
@pytest.mark.parametrize("id", [id for id in ALL if id not in ("sensor2_lag", "base_compliance")])
def test_next_to_no_size_changes_next_to_nothing(id):
    y = readings_of(drawn(ALL[id], scale=1e-9))
    np.testing.assert_allclose(y, without(), rtol=0.0, atol=1e-7)


@every_effect
def test_acts_through_its_channel(id):
    effect = ALL[id]
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


@every_effect
def test_is_the_same_again_with_the_same_seed(id):
    ts = TS[:151]
    one, two, other = drawn(ALL[id]), drawn(ALL[id]), drawn(ALL[id], seed=1)
    first = one.run(ts, omega=OMEGA)
    np.testing.assert_array_equal(first, two.run(ts, omega=OMEGA))
    assert not np.array_equal(first, other.run(ts, omega=OMEGA)) or id in UNSEEN | {"drive_steps"}
    # and so is the second run, which chance may make another
    np.testing.assert_array_equal(one.run(ts, omega=OMEGA), two.run(ts, omega=OMEGA))


@every_effect
def test_takes_its_time_but_ends(id):
    # decays too, and rigs of other sizes
    rng = np.random.default_rng(7)
    p = BENCH.scaled(rng, 0.5)
    draw = ALL[id].draw(rng, p)
    for omega in (None, p.natural_frequency):
        rig = VirtualRig(p, {id: draw.sizes}, shapes=draw.shapes)
        assert np.isfinite(readings_of(rig, omega)).all()
        assert rig.switches < 250
        assert rig.steps < 10_000


def sizes_of(id: str) -> tuple[dict[str, float], dict[str, float]]:
    """Half the sizes that the model calls typical, a shape constant from the middle of its grid."""
    effect = model_catalogue().get(id)
    if effect is None:
        return SIZES[id], dict(ALL[id].shapes)
    sizes = {a.name: 0.5 * a.typical for a in effect.amplitudes}
    return SIZES.get(id, sizes), {s.name: s.grid[len(s.grid) // 2] for s in effect.shapes}


def difference(id: str, sizes, shapes) -> np.ndarray:
    """What the hidden effect changes in the rig's readings."""
    rig = VirtualRig(
        effects={id: tuple(sizes.values())}, shapes={f"{id}.{n}": v for n, v in shapes.items()}
    )
    return readings_of(rig, run_values={id: tuple(sizes.values())}) - without()


def correlation(a, b) -> float:
    return float(np.sum(a * b) / np.sqrt(np.sum(a * a) * np.sum(b * b)))


# A step of the motor changes less than 0.02 mrad, which the reference cannot follow.
@pytest.mark.parametrize("id", sorted(IDS - set(WITH_STATES) - UNSEEN - {"drive_steps"}))
def test_changes_what_the_catalogue_says(id):
    assert id in FORMULAS
    p = NUMBERS | dict(omega=OMEGA, middle=1.0, drift=0.5)
    sizes, shapes = sizes_of(id)
    values = sizes | shapes
    catalogued = readings(p, TS, reference(p, TS, effect=id, values=values), id, values)
    catalogued -= reference(p, TS)[:, :2]
    hidden = difference(id, sizes, shapes)
    for channel in (0, 1):
        if rms(catalogued)[channel] > 1e-6:
            assert correlation(hidden[:, channel], catalogued[:, channel]) > 0.999
    # and by as much: what differs is the smoothing of the reference
    assert rms(hidden - catalogued).max() < 0.02 * rms(catalogued).max()


@pytest.mark.parametrize("id", WITH_STATES)
def test_changes_what_the_catalogue_says_with_states(id):
    p = NUMBERS | dict(omega=OMEGA)
    sizes, shapes = sizes_of(id)
    catalogued = smoothed(p, TS, id, sizes | shapes) - smoothed(p, TS)
    hidden = difference(id, sizes, shapes)
    for channel in (0, 1):
        assert correlation(hidden[:, channel], catalogued[:, channel]) > 0.97
    # networks of sliders are no Dahl states, the others are what the catalogue has
    part = 0.25 if id not in ("base_compliance", "drive_backlash") else 0.01
    assert rms(hidden - catalogued).max() < part * rms(catalogued).max()


def test_the_staircase_is_followed_to_the_step():
    # coarse treads, against an average over each millisecond of the same staircase
    q = np.pi / 8
    rig = VirtualRig(effects={"drive_steps": 1.0}, shapes={"drive_steps.q": q})
    y = readings_of(rig)
    assert rms(y - without()).max() > 1e-3
    half = VirtualRig(effects={"drive_steps": 0.5}, shapes={"drive_steps.q": q})
    assert correlation(readings_of(half) - without(), y - without()) > 0.9


def test_each_run_has_values_of_its_own_within_the_size():
    rig = VirtualRig(effects={"drive_frequency": 0.3, "contact_vibration": 0.4}, seed=3)
    seen = []
    for _ in range(20):
        rig.start(omega=OMEGA)
        seen.append(rig.run_values)
    detunings = [own["drive_frequency"][0] for own in seen]
    assert len(set(detunings)) == 20
    assert max(map(abs, detunings)) <= 0.3
    assert {round(float(np.hypot(*own["contact_vibration"])), 12) for own in seen} == {0.4}


def test_what_else_is_hidden_does_not_change_the_chance():
    one = VirtualRig(effects={"drive_frequency": 0.3}, seed=3)
    two = VirtualRig(effects={"column_tilt": 0.01, "drive_frequency": 0.3}, seed=3)
    one.start(omega=OMEGA)
    two.start(omega=OMEGA)
    assert one.run_values["drive_frequency"] == two.run_values["drive_frequency"]


def test_two_effects_at_once():
    both = VirtualRig(effects={"spring_hardening": 0.2, "sensor_crosstalk": 0.05})
    one = VirtualRig(effects={"spring_hardening": 0.2})
    y, x = readings_of(both), readings_of(one)
    np.testing.assert_array_equal(y[:, 0], x[:, 0])
    np.testing.assert_allclose(y[:, 1], x[:, 1] + 0.05 * x[:, 0], atol=1e-15)


@pytest.mark.parametrize("seed", range(12))
def test_any_two_effects_on_any_rig(seed):
    rng = np.random.default_rng(seed)
    p = BENCH.scaled(rng, 0.5)
    pair = rng.choice(list(ALL), 2, replace=False)
    draws = {id: ALL[id].draw(rng, p) for id in pair.tolist()}
    rig = VirtualRig(
        p,
        {id: draw.sizes for id, draw in draws.items()},
        seed=seed,
        shapes={name: value for draw in draws.values() for name, value in draw.shapes.items()},
    )
    y = rig.run(TS[:251], omega=p.natural_frequency)
    assert np.isfinite(y).all()
    assert rig.switches < 150


@pytest.mark.parametrize(
    ("given", "says"),
    [
        (dict(effects={"nothing": 1.0}), "no effect 'nothing' to hide, choose from: base_compl"),
        (dict(effects={"column_tilt": (1.0, 2.0, 3.0)}), "takes 2 sizes"),
        (dict(effects={"column_tilt": float("nan")}), "must be finite"),
        (dict(effects={"column_tilt": 0.1}, shapes={"column_tilt.n": 2.0}), "no shape constant"),
        (dict(effects={"bearing_stribeck": 0.1}, shapes={"bearing_stribeck.vs": 0.0}), "above"),
    ],
)
def test_what_cannot_be_hidden_is_said(given, says):
    with pytest.raises(InputError, match=says) as fault:
        VirtualRig(**given)
    assert "\n" not in str(fault.value)
