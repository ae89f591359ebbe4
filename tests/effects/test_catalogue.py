"""The catalogue: what it must list, what every class must say, and effects of one's own."""

import importlib
import inspect
import math
import pkgutil

import numpy as np
import pytest

import tp_jax.effects
from tp_jax.effects import CHANNELS, Amplitude, Effect, Shape, catalogue, get, register, unregister
from tp_jax.model.motion import Motion

#: Ids and locations are fixed: results and checks use them.
LOCATIONS = {
    "drive_harmonics": "drive",
    "drive_backlash": "drive",
    "drive_frequency": "drive",
    "drive_steps": "drive",
    "spring_asymmetry": "spring",
    "spring_hysteresis": "spring",
    "spring_hardening": "spring",
    "spring_relaxation": "spring",
    "bearing_stribeck": "bearing",
    "bearing_position": "bearing",
    "bearing_presliding": "bearing",
    "bearing_drag": "bearing",
    "bearing_warmup": "bearing",
    "bearing_asymmetry": "bearing",
    "contact_stribeck": "contact",
    "contact_position": "contact",
    "contact_presliding": "contact",
    "contact_wear": "contact",
    "contact_asymmetry": "contact",
    "contact_vibration": "contact",
    "contact_cogging": "contact",
    "contact_repeatability": "contact",
    "column_tilt": "column",
    "column_cable": "column",
    "base_compliance": "base",
    "sensor1_nonlinearity": "sensor1",
    "sensor2_nonlinearity": "sensor2",
    "sensor1_drift": "sensor1",
    "sensor2_drift": "sensor2",
    "sensor_crosstalk": "sensor2",
    "channel_delay": "clock",
    "clock_skew": "clock",
    "reaction_factor": "model",
    "sensor1_eccentricity": "sensor1",
    "sensor2_eccentricity": "sensor2",
    "sensor1_interpolation": "sensor1",
    "sensor2_interpolation": "sensor2",
    "drive_delay": "clock",
    "bearing_load": "bearing",
    "spring_deadzone": "drive",
    "elastic_stop": "column",
}

#: Amplitudes of which every recording has its own.
OWN = {"drive_frequency": "a", "contact_vibration": "ab", "contact_repeatability": "a"}

GRIDS = {
    "drive_steps": (math.pi / 100, math.pi / 800, math.pi / 1600),
    "spring_hysteresis": (0.03, 0.1, 0.3),
    "bearing_stribeck": (0.1, 0.3, 1.0, 3.0),
    "contact_stribeck": (0.1, 0.3, 1.0, 3.0),
    "bearing_position": (1, 2, 3, 4, 5, 6),
    "contact_position": (1, 2, 3, 4, 5, 6),
    "bearing_presliding": (1e-3, 3e-3, 1e-2, 3e-2),
    "contact_cogging": (1, 2, 3, 4),
    "column_cable": (0.05, 0.15, 0.5),
    "sensor1_interpolation": (2, 4),
    "sensor2_interpolation": (2, 4),
    "elastic_stop": (0.05, 0.1, 0.2, 0.4, 0.8),
}

every_effect = pytest.mark.parametrize("effect", catalogue().values(), ids=list(catalogue()))
modules = [
    m.name
    for m in pkgutil.iter_modules(tp_jax.effects.__path__)
    if m.name not in ("base", "laws", "registry", "trial")
]


def test_no_id_but_those_of_the_table():
    assert set(catalogue()) <= set(LOCATIONS)
    assert len(catalogue()) >= 41
    assert list(catalogue()) == sorted(catalogue())


@every_effect
def test_location_and_channel(effect):
    assert effect.location == LOCATIONS[effect.id]
    expected = {"contact": "contact", "sensor1": "sensor1", "sensor2": "sensor2", "clock": "clock"}
    assert effect.channel == expected.get(effect.location, "column")
    assert effect.channel == CHANNELS[effect.location]


@every_effect
def test_says_what_it_is(effect):
    for text in (effect.formula, effect.source, effect.looks_like, type(effect).__doc__):
        assert text
        assert text.strip()
    assert effect.formula in type(effect).__doc__


@every_effect
def test_amplitudes_and_shapes_are_sound(effect):
    taken = list(inspect.signature(effect.increment).parameters)[1:]
    assert taken == [n.name for n in (*effect.amplitudes, *effect.shapes)]
    for a in effect.amplitudes:
        assert a.unit
        assert a.typical > 0.0
        assert a.lower <= 0.0 < a.upper  # zero is within, or the edge of what is physical
        assert a.per_recording == (a.name in OWN.get(effect.id, ""))
        assert effect.qualified(a.name) == f"{effect.id}.{a.name}"
    for s in effect.shapes:
        assert s.unit
        assert (np.array(s.grid) > 0.0).all()
    if effect.id in GRIDS:
        assert effect.shapes[0].grid == pytest.approx(GRIDS[effect.id])
    if effect.id == "contact_vibration":
        assert (min(effect.shapes[0].grid), max(effect.shapes[0].grid)) == (3.0, 60.0)


@every_effect
def test_needs_follow_from_what_it_is(effect):
    assert effect.needs <= {"rider", "sine", "measured", "commanded", "several", "inertias"}
    about_phi2 = effect.hook in ("contact", "sensor2")
    assert ("rider" in effect.needs) == (about_phi2 or effect.id == "reaction_factor")
    if effect.id == "reaction_factor":
        assert "inertias" in effect.needs
    if effect.id == "contact_repeatability":
        assert "several" in effect.needs
    assert ("measured" in effect.needs) == bool(effect.reads_later)
    if effect.hook in ("phase", "clock"):
        assert "sine" in effect.needs


@pytest.mark.parametrize("name", modules)
def test_a_module_is_one_effect_of_its_name(name):
    module = importlib.import_module(f"tp_jax.effects.{name}")
    classes = [
        value
        for value in vars(module).values()
        if inspect.isclass(value) and value.__module__ == module.__name__
    ]
    assert len(classes) == 1
    assert issubclass(classes[0], Effect)
    assert classes[0].id == name
    assert classes[0].__name__.lower() == name.replace("_", "")
    assert module.__doc__


def test_every_module_is_in_the_catalogue():
    assert set(modules) == set(catalogue())


def test_by_id():
    assert get("column_tilt") is catalogue()["column_tilt"]
    with pytest.raises(KeyError, match=r"no effect 'nothing'.*column_tilt"):
        get("nothing")


class Own(Effect):
    """`a phi1^2`"""

    id = "own_spring"
    location = "spring"
    hook = "spring"
    amplitudes = (Amplitude("a", "N m/rad^2"),)

    def increment(self, m, a):
        return a * m.phi1**2


@pytest.mark.parametrize("given", [Own, Own()])
def test_an_effect_of_ones_own(given):
    try:
        assert register(given) is given
        assert isinstance(get("own_spring"), Own)
        assert set(catalogue()) - {"own_spring"} <= set(LOCATIONS)
    finally:
        unregister("own_spring")
    assert "own_spring" not in catalogue()
    unregister("own_spring")  # a second time is no fault


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"id": ""}, "identifier"),
        ({"id": "not an id"}, "identifier"),
        ({"location": "cellar"}, "location"),
        ({"hook": "nowhere"}, "hook"),
        ({"amplitudes": ()}, "at least one amplitude"),
    ],
)
def test_a_faulty_effect_is_refused(change, said):
    before = set(catalogue())
    with pytest.raises(ValueError, match=said):
        register(type("Faulty", (Own,), change))
    assert set(catalogue()) == before


def _changed(increment, **change):
    return type("Faulty", (Own,), {"increment": increment, **change})


@pytest.mark.parametrize(
    ("faulty", "said"),
    [
        (_changed(lambda self, m, b: b * m.phi1), r"unexpected keyword argument 'a'.*self, m, a"),
        (_changed(lambda self, m, a: a * m.angle), "no attribute 'angle'"),
        (_changed(lambda self, m, a: a * m.v1**0.5), "no finite number"),
        (_changed(lambda self, m, a: a * m.phi1[:3]), "cannot be evaluated"),
        (_changed(lambda self, m, a: a * m.phi1, needs=frozenset({"ridr"})), "needs ridr"),
    ],
)
def test_a_formula_that_fails_is_refused_where_it_is_registered(faulty, said):
    with pytest.raises(ValueError, match=said):
        register(faulty)
    assert "own_spring" not in catalogue()


@every_effect
def test_says_what_to_do(effect):
    for text in (effect.remedy, effect.by_hand):
        assert text
        assert text[0].islower()
        assert not text.endswith(".")


def test_an_effect_of_ones_own_brings_its_clause():
    from tp_jax.report import words

    register(type("Told", (Own,), {"says": "the spring is odd"}))
    try:
        assert words.effect("own_spring") == "the spring is odd"
    finally:
        unregister("own_spring")


def test_an_effect_must_define_its_increment():
    faulty = type("Faulty", (Effect,), {"id": "faulty"})
    with pytest.raises(NotImplementedError, match="faulty"):
        faulty().increment(Motion(t=0.0))
    assert Shape("n", "1", (1.0,)).continuous is False
