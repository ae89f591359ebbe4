"""What effects with a memory need of the pendulum: the rate of the drive, a base that turns."""

import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from tests.reference import BENCH
from tp_jax.effects import Amplitude, Applied, Effect, get
from tp_jax.model import presets
from tp_jax.model.drive import PiecewiseCubicDrive
from tp_jax.model.pendulum import SingleTorsionPendulum
from tp_jax.simulation import simulate

T = jnp.asarray(0.337)
Y = tuple(jnp.asarray(x) for x in (0.2, -0.1, 3.0, -2.0))


def pendulum(*terms: Applied):
    return presets.double_pendulum(**BENCH, terms=terms)


def rate_and_difference(model, t=T, h=1e-6) -> tuple[float, float]:
    ends = [float(model.motion(t + x, Y).f) for x in (h, -h)]
    return float(model.motion(t, Y).f_rate()), (ends[0] - ends[1]) / (2.0 * h)


@pytest.mark.parametrize(
    "terms",
    [
        (),
        (("drive_harmonics", {"a": 0.05, "b": -0.03}),),
        (("drive_frequency", {"a": 0.4}), ("drive_harmonics", {"a": 0.05, "b": 0.0})),
    ],
)
def test_rate_of_the_drive(terms):
    model = pendulum(*(Applied(get(id), v) for id, v in terms))
    found, expected = rate_and_difference(model)
    assert abs(expected) > 0.1
    assert found == pytest.approx(expected, rel=1e-7)


def test_rate_of_a_measured_drive():
    t = np.arange(200) / 100.0
    reading = 2.0 + 0.3 * np.sin(13.0 * t)
    drive = PiecewiseCubicDrive(0.7, 0.0, t, CubicSpline(t, reading).c)
    found, expected = rate_and_difference(dataclasses.replace(pendulum(), drive=drive))
    assert found == pytest.approx(expected, rel=1e-6)
    assert found == pytest.approx(0.7 * 0.3 * 13.0 * np.cos(13.0 * 0.337), rel=1e-3)


class Shaken(Effect):
    """A base that is shaken: psi'' = a cos 20 t."""

    id = "own_shaken"
    location = "base"
    hook = "base"
    amplitudes = (Amplitude("a", "rad/s^2"),)

    def increment(self, m, a):
        return a * jnp.cos(20.0 * m.t)


def test_a_base_that_turns_takes_bearing_and_spring_along_but_not_the_rider():
    shaken = pendulum(Applied(Shaken(), {"a": jnp.asarray(30.0)}))
    psi2 = 30.0 * np.cos(20.0 * 0.337)
    motions = (model.motion(T, Y) for model in (pendulum(), shaken))
    bare, found = ((float(m.a1), float(m.a2)) for m in motions)
    assert found[0] == pytest.approx(bare[0] - psi2)
    # relative to the column, which turns with the base; its own motion is that of the torques
    assert found[1] == pytest.approx(bare[1], rel=1e-12)


def test_a_column_alone_on_a_base_that_turns():
    numbers = pendulum(Applied(Shaken(), {"a": jnp.asarray(30.0)}))
    alone = SingleTorsionPendulum(
        drive=numbers.drive,
        spring=numbers.spring,
        bearing=numbers.bearing,
        B1=numbers.B1,
        terms=numbers.terms,
    )
    still = dataclasses.replace(alone, terms=())
    expected = float(still.motion(T, Y).a1) - 30.0 * np.cos(20.0 * 0.337)
    assert float(alone.motion(T, Y).a1) == pytest.approx(expected)
    assert np.isfinite(simulate(alone, np.linspace(0.0, 0.5, 51)).phi1).all()
