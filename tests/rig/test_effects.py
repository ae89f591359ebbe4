"""Every effect that can be hidden: nothing at zero, its own channel, the catalogue's formula."""

import subprocess
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from tests.reference import BENCH as NUMBERS
from tests.reference import FORMULAS, readings, reference
from tests.rig.any_effect import (
    OMEGA,
    TS,
    UNSEEN,
    any_two_effects_on_any_rig,
    demands,
    readings_of,
    rms,
    without,
)
from tests.rig.dahl import EFFECTS as WITH_STATES
from tests.rig.dahl import smoothed
from tp_jax.effects import catalogue as model_catalogue
from tp_jax.errors import InputError
from tp_jax.rig import VirtualRig
from tp_jax.rig.effects import Effect, catalogue, registry

#: Without those that trials register.
ALL = {id: effect for id, effect in catalogue().items() if effect.in_catalogue}

#: The catalogue's ids, which are fixed: results and checks use them.
IDS = {
    "drive_harmonics",
    "drive_backlash",
    "drive_frequency",
    "drive_steps",
    "spring_asymmetry",
    "spring_hysteresis",
    "spring_hardening",
    "spring_relaxation",
    "bearing_stribeck",
    "bearing_position",
    "bearing_presliding",
    "bearing_drag",
    "bearing_warmup",
    "bearing_asymmetry",
    "contact_stribeck",
    "contact_position",
    "contact_presliding",
    "contact_wear",
    "contact_asymmetry",
    "contact_vibration",
    "contact_cogging",
    "contact_repeatability",
    "column_tilt",
    "column_cable",
    "base_compliance",
    "sensor1_nonlinearity",
    "sensor2_nonlinearity",
    "sensor1_drift",
    "sensor2_drift",
    "sensor_crosstalk",
    "channel_delay",
    "clock_skew",
    "reaction_factor",
    "sensor1_eccentricity",
    "sensor2_eccentricity",
    "sensor1_interpolation",
    "sensor2_interpolation",
    "drive_delay",
    "bearing_load",
    "spring_deadzone",
    "elastic_stop",
}

#: A modest size where that of the model's catalogue is none.
SIZES = {
    "spring_hysteresis": {"a": 0.1},
    "bearing_presliding": {"a": 0.5},
    "contact_presliding": {"a": 0.5},
    "column_cable": {"a": 0.05},
    "base_compliance": {"a": 0.1},
    "drive_backlash": {"g": 0.01},
}


def test_the_whole_catalogue_can_be_hidden():
    assert set(ALL) == IDS


@pytest.mark.parametrize(("demand", "id"), demands(ALL))
def test_every_effect(demand, id):
    demand(id)


@pytest.mark.parametrize("id", sorted(IDS & set(model_catalogue())))
def test_places_and_units_are_those_of_the_model(id):
    here, there = ALL[id], model_catalogue()[id]
    assert (here.location, here.channel) == (there.location, there.channel)
    assert here.amplitudes == tuple(a.name for a in there.amplitudes)
    units = tuple(a.unit for a in there.amplitudes)
    assert here.unit == units
    assert set(here.shapes) == {s.name for s in there.shapes}


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
    any_two_effects_on_any_rig(ALL, seed)


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


def test_registers_effects_of_others(monkeypatch):
    class Magnet(Effect):
        """A pull."""

        id = "own_magnet"
        channel, location = "column", "column"

        def install(self, run, a):
            run.hooks.column.append(lambda m: -a * m.phi1)

    class Taken(Effect):
        """Another effect by the same name."""

        id = "own_magnet"

    monkeypatch.setattr(registry, "_registered", dict(registry._registered))
    family, other = ModuleType("family"), ModuleType("other")
    family.Magnet, other.Taken = Magnet, Taken
    registry.register(family)
    registry.register(family)
    assert list(catalogue()) == sorted(catalogue())
    assert catalogue()["own_magnet"].location == "column"
    rig = VirtualRig(effects={"own_magnet": 0.05})
    assert rms(readings_of(rig) - without()).max() > 1e-4
    with pytest.raises(ValueError, match="'own_magnet' already"):
        registry.register(other)


def test_the_package_does_without_effects_of_others():
    code = (
        "import sys; from tp_jax.rig.effects import catalogue\n"
        "assert all(effect.in_catalogue for effect in catalogue().values())\n"
        "assert 'trials' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=Path(__file__).parents[2])
