"""Cousins: akin to an effect of the catalogue, where it is, by another formula."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from tests.rig.test_effects import IDS
from tp_jax import effects
from tp_jax.effects.laws import laws
from tp_jax.rig import BENCH
from tp_jax.rig.effects import catalogue
from tp_jax.rig.effects.base import Run
from tp_jax.rig.hooks import Hooks, Instant
from trials.effects.base import is_cousin
from trials.effects.patterns import saw, settling
from trials.judge import _family

COUSINS = {id: e for id, e in catalogue().items() if is_cousin(e)}
every_cousin = pytest.mark.parametrize("id", sorted(COUSINS))

#: Instant, then what the law adds there at amplitudes a, b and these shapes, by hand.
AT = dict(phi1=0.3, phi2=-0.4, v1=2.0, v2=-1.5, d=-0.25, t=1.3, s=0.1)
E01 = (1 - math.exp(-0.6 / 0.2)) / (1 - math.exp(-5)) - 0.5
LAWS = {
    "bearing_stribeck_exponential": ("bearing", dict(vs=0.5), lambda a: a * math.exp(-4)),
    "bearing_drag_power": ("column", {}, lambda a: -a * 2.0**1.6),
    "bearing_square": ("bearing", dict(n=3.0, beta=1.0), lambda a: a),
    "bearing_bump": (
        "bearing",
        dict(centre=0.2, width=0.1),
        lambda a: a * math.exp(-0.5),
    ),
    "bearing_warmup_exponential": ("bearing", dict(tau=0.2), lambda a: a * E01),
    "bearing_asymmetry_speed": ("bearing", dict(vs=1.0), lambda a: a * 2.0 / 3.0),
    "contact_stribeck_exponential": ("grip", dict(vs=0.5), lambda a: a * math.exp(-3)),
    "contact_square": ("grip", dict(n=3.0, beta=1.0), lambda a: -a),
    "contact_bump": ("grip", dict(centre=-0.5, width=0.1), lambda a: a * math.exp(-0.5)),
    "contact_wear_exponential": ("grip", dict(tau=0.2), lambda a: a * E01),
    "contact_asymmetry_speed": ("grip", dict(vs=1.5), lambda a: -a * 0.5),
    "contact_cogging_saw": ("contact", dict(n=2.0, beta=1.0), lambda a: -a * 1.8 / math.pi),
    "contact_vibration_square": ("grip", dict(W=2.0), lambda a: -a),
    "contact_vibration_chirp": (
        "grip",
        dict(W=2.0, rise=0.2),
        lambda a: a * math.cos(4 * math.pi * 1.01 * 1.0),
    ),
    "spring_hardening_quintic": ("column", {}, lambda a: -BENCH.k * a * 0.25**5),
    "spring_hardening_exponential": (
        "column",
        dict(w=0.5),
        lambda a: -BENCH.k * a * 0.5 * (math.exp(0.5) - 1.5),
    ),
    "spring_asymmetry_smooth": (
        "column",
        dict(w=0.1),
        lambda a: BENCH.k * a * (math.hypot(0.25, 0.1) - 0.1),
    ),
    "spring_asymmetry_quadratic": ("column", {}, lambda a: BENCH.k * a * 0.0625),
    "spring_relaxation_exponential": ("column", dict(tau=0.2), lambda a: -BENCH.k * a * E01 * 0.25),
    "column_tilt_second": (
        "column",
        dict(beta=1.0, r=0.5),
        lambda a: -a * (math.sin(1.3) + 0.5 * math.sin(2.6)),
    ),
    "sensor1_eccentric": ("sensor1", dict(c=1.0), lambda a: a * (math.sin(1.3) - math.sin(1.0))),
    "sensor2_eccentric": ("sensor2", dict(c=1.0), lambda a: a * (math.sin(0.6) - math.sin(1.0))),
    "sensor1_compression": ("sensor1", dict(w=0.5), lambda a: -a * (0.3 - 0.5 * math.tanh(0.6))),
    "sensor1_drift_exponential": ("sensor1", dict(tau=0.2), lambda a: 0.3 * a * E01),
    "sensor2_drift_exponential": ("sensor2", dict(tau=0.2), lambda a: -0.4 * a * E01),
}


def instant() -> Instant:
    m = Instant()
    for name, value in AT.items():
        setattr(m, name, value)
    return m


def added(id: str, a: float) -> tuple[str, float]:
    """Where a cousin takes hold of a run of 10 s, and what its law adds at that instant."""
    where, shapes, _ = LAWS[id]
    hooks, effect = Hooks(), catalogue()[id]
    sizes = (a,) + (0.0,) * (len(effect.amplitudes) - 1)
    effect.install(Run(hooks, BENCH, 13.0, 10.0, np.random.default_rng(0), shapes), *sizes)
    m = instant()
    for commit in hooks.commits:
        commit(m, False)
    # the bearing slides forward, the contact backward
    m.side, m.speed = (1.0, 2.0) if where == "bearing" else (-1.0, 1.5)
    laws = getattr(hooks, where)
    if where.startswith("sensor"):
        y = AT["phi1" if where == "sensor1" else "phi2"]
        return where, laws[0](y, m) - y
    return where, laws[0](m)


@pytest.mark.parametrize("id", sorted(LAWS))
def test_formula(id):
    _, found = added(id, 0.2)
    assert found == pytest.approx(LAWS[id][2](0.2), abs=1e-12)


@pytest.mark.parametrize("id", sorted(LAWS))
def test_is_nothing_at_amplitude_zero(id):
    assert added(id, 0.0)[1] == 0.0


def test_third_harmonic():
    hooks = Hooks()
    run = Run(hooks, BENCH, 13.0, 10.0, np.random.default_rng(0), {})
    catalogue()["drive_harmonics_third"].install(run, 0.1)
    found = hooks.drive[0](0.5, 0.4)
    assert found == pytest.approx(0.5 + 0.1 * BENCH.A * math.sin(1.2))


@every_cousin
def test_is_where_its_kind_is(id):
    effect, kind = COUSINS[id], catalogue()[COUSINS[id].cousin_of]
    assert effect.cousin_of in IDS
    assert not effect.in_catalogue
    assert (effect.location, effect.channel) == (kind.location, kind.channel)
    assert effect.needs_rider == kind.needs_rider
    if effect.family:  # a law that a diagnosis can learn; over time not all places have one
        assert _family(effect.family) in {_family(law) for law in laws()}
        assert _family(effect.family)[0] == effect.location


@pytest.mark.parametrize("id", ["sensor1_eccentric", "sensor2_eccentric"])
def test_an_eccentric_disc_is_of_the_formula_that_the_catalogue_has(id):
    known = effects.get(COUSINS[id].cousin_of)
    a, c = 0.05, 1.1
    phi = np.linspace(-2.0, 2.0, 9)
    two = known.increment(SimpleNamespace(phi1=phi, phi2=phi), a * math.cos(c), a * math.sin(c))
    np.testing.assert_allclose(two, a * (np.sin(phi + c) - math.sin(c)), atol=1e-15)


def test_all_new_ones_have_their_formula_checked():
    new = {id for id, e in COUSINS.items() if e.rough_only}
    assert new == {*LAWS, "drive_harmonics_third"}


def test_patterns():
    assert settling(-0.5, 0.3) == -0.5
    assert settling(0.5, 0.3) == pytest.approx(0.5)
    assert settling(0.0, 0.3) > 0.25
    assert saw(0.0) == 0.0
    assert saw(3.0) == pytest.approx(3.0 / math.pi)
    assert saw(3.3) == pytest.approx(3.3 / math.pi - 2.0)
