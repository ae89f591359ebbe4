"""What bounds a step: coming reversals, and layers of friction that need not be resolved."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import tp_jax as tp
from tp_jax.simulation.control import Control, error_ratio, layers, reversal_rate

EPS = (jnp.array([5e4]), jnp.array([5e4]))
NATURAL = jnp.array([290.0])
C = Control()


def state(v1=0.0, v2=0.0, a1=0.0, a2=0.0):
    return [jnp.array([x]) for x in (0.0, 0.0, v1, v2)], [jnp.array([x]) for x in (v1, v2, a1, a2)]


def jumps(first, second):
    return jnp.array([first]), jnp.array([second])


def test_a_creeping_body_does_not_reverse_by_what_a_step_left():
    # stuck at 1/eps: friction takes back 8000 / (2 pi) rad/s^2 on the way to zero
    y, f = state(v2=2e-5, a2=-9.0)
    known = layers(f, jumps(0.0, 8000.0), NATURAL, C)
    assert float(reversal_rate(y, f, EPS, C)[0]) > 1e4
    assert float(reversal_rate(y, f, EPS, C, known)[0]) == 0.0


def test_a_body_that_comes_to_rest_is_followed():
    y, f = state(v2=3e-4, a2=-400.0)
    known = layers(f, jumps(0.0, 8000.0), NATURAL, C)
    assert known.harmless[1] == 0.0
    bound = float(reversal_rate(y, f, EPS, C)[0])
    assert float(reversal_rate(y, f, EPS, C, known)[0]) == bound > 1e5


def test_a_body_far_from_its_layer_comes_close_to_it_in_one_step():
    y, f = state(v2=1.0, a2=-400.0)
    known = layers(f, jumps(0.0, 8000.0), NATURAL, C)
    left = 1.0 - 400.0 / float(reversal_rate(y, f, EPS, C, known)[0])
    assert left == pytest.approx(1.0 - C.leap + C.near / 5e4)


def test_a_body_turned_by_a_stiff_spring_may_jump_over_its_layer():
    y, f = state(v1=1e-4, a1=-4e4)
    known = layers(f, jumps(1.0, 0.0), NATURAL, C)
    longest = 1.0 / float(reversal_rate(y, f, EPS, C, known)[0])
    assert longest == pytest.approx(C.crossing * C.velocity * 290.0 * C.angle / 1.0)
    # and the step over it is a good one, which it is not where layers have to be resolved
    end, _ = state(v1=-1.0)
    error = [jnp.zeros(1)] * 4
    h = jnp.array([longest])
    ratio = float(error_ratio(y, end, error, EPS, NATURAL, C, h, known)[0])
    assert ratio == pytest.approx(C.crossing)
    assert float(error_ratio(y, end, error, EPS, NATURAL, C)[0]) > 1.0
    # tangents have to see every layer
    none = layers(f, jumps(1.0, 0.0), NATURAL, Control(crossing=0.0))
    assert none.harmless[0] == 0.0
    assert np.isinf(none.weight[0])


def test_fast_columns_cost_few_steps_and_stay_right():
    """46 Hz, nearly undamped; the rider sticks and slips a thousand times in ten seconds."""
    fast = {
        "k": 1160.0,
        "A": 1.3,
        "B1": 0.0139,
        "B2": 0.00101,
        "c1": 0.000388,
        "M1": 4.05e-06,
        "Tv": 0.000476,
        "Ts1": 4.08,
        "Tst": 9.14,
        "T0": 0.0567,
        "omega": 13.1,
    }
    models = jax.vmap(lambda k: tp.presets.double_pendulum(**fast | {"k": k}, eps=5e4))(
        np.array([fast["k"]])
    )
    ts = np.linspace(0.0, 1.0, 251)
    found = tp.sweep(models, ts, tolerance=2e-6)
    right = tp.sweep(models, ts, tolerance=1e-9)
    assert found.steps[0] < 5000  # 7023 if whatever acceleration a step leaves meant a reversal
    assert np.abs(found.phi1 - right.phi1).max() < 1e-4
    assert np.abs(found.phi2 - right.phi2).max() < 1e-4
