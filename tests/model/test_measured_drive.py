"""A measured drive, read in any unit from any zero, moves a rig as the same drive commanded."""

import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from tests.reference import BENCH
from tp_jax.effects import Applied, catalogue, laws
from tp_jax.model import presets
from tp_jax.model.drive import PiecewiseCubicDrive
from tp_jax.model.spring import LinearSpring

GAIN, ZERO = -0.02, 130.0  # rad per count; counts of a drive that stands
EVERY = {e.id: e for e in catalogue().values() if not e.needs & {"sine", "measured"}}
STATES = [(0.21, 0.1, 1.4, -0.8), (-0.3, 0.4, -2.0, 1e-5), (0.05, 0.0, 0.3, 3.0)]


def sizes(effect):
    amplitudes = {a.name: a.typical for a in effect.amplitudes}
    return amplitudes | {s.name: s.grid[len(s.grid) // 2] for s in effect.shapes}


def moved(model, t, y):
    """Accelerations and the rates of the effects' own states."""
    return np.array([float(x) for x in model.derivative(jnp.asarray(t), y)[2:]])


@pytest.mark.parametrize("id", EVERY)
def test_every_effect_moves_it_as_a_commanded_one(id):
    """A spring's torque is of its winding, not of what is read at its end."""
    effect = EVERY[id]
    commanded = presets.double_pendulum(**BENCH, terms=(Applied(effect, sizes(effect)),))
    commanded = dataclasses.replace(commanded, drift=(1.0, 0.5))
    knots = np.linspace(0.0, 2.0, 2001)
    angle = BENCH["A"] * np.sin(BENCH["omega"] * knots)
    read = CubicSpline(knots, ZERO + angle / GAIN)
    drive = PiecewiseCubicDrive(GAIN, -GAIN * ZERO, knots, read.c)
    measured = dataclasses.replace(commanded, drive=drive)
    for t, state in zip((0.3, 0.9, 1.7), STATES, strict=True):
        y = tuple(map(jnp.asarray, (*state, *[0.01] * effect.n_states)))
        np.testing.assert_allclose(moved(measured, t, y), moved(commanded, t, y), rtol=1e-6)


def test_laws_ask_for_the_same_winding():
    commanded = presets.double_pendulum(**BENCH)
    knots = np.linspace(0.0, 2.0, 2001)
    read = CubicSpline(knots, ZERO + BENCH["A"] * np.sin(BENCH["omega"] * knots) / GAIN)
    drive = PiecewiseCubicDrive(GAIN, -GAIN * ZERO, knots, read.c)
    measured = dataclasses.replace(commanded, drive=drive)
    y = tuple(map(jnp.asarray, STATES[0]))
    motions = [m.motion(jnp.asarray(0.4), y) for m in (commanded, measured)]
    for law in laws().values():
        if law.argument.symbol == "θ":
            continue  # the phase of a sine, which a measured drive has not
        one, other = (float(law.argument.of(m)) for m in motions)
        assert other == pytest.approx(one, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("id", ["spring_hardening", "spring_asymmetry", "spring_deadzone"])
def test_a_preload_moves_where_a_spring_is_relaxed_and_not_where_it_rests(id):
    plain = presets.double_pendulum(**BENCH)
    preload = 0.2
    wound = dataclasses.replace(plain, spring=LinearSpring(BENCH["k"], preload))
    t, y = jnp.asarray(0.3), tuple(map(jnp.asarray, STATES[0]))
    assert [float(x) for x in wound.derivative(t, y)] == pytest.approx(
        [float(x) for x in plain.derivative(t, y)]
    )
    effect = EVERY[id]
    assert effect.uses_winding
    increment = lambda m: float(effect.increment(m, **sizes(effect)))  # noqa: E731
    ahead = (STATES[0][0] - preload, *STATES[0][1:])
    there = plain.motion(t, tuple(map(jnp.asarray, ahead)))
    assert increment(wound.motion(t, y)) == pytest.approx(increment(there))
