"""What a gap, bristles, a rubbing spring, a cable and a soft base are known to do."""

import itertools

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.effects.own_states import angles, bench, effect
from tests.reference import BENCH
from tests.rig.dahl import play
from tp_jax.effects import Applied
from tp_jax.model import presets
from tp_jax.model.pendulum import SingleTorsionPendulum

B1, B2, K = BENCH["B1"], BENCH["B2"], BENCH["k"]


def alone(id: str, values, **changes) -> SingleTorsionPendulum:
    """The bench's column without its rider, motor at rest, with an effect."""
    double = presets.double_pendulum(**BENCH | dict(A=0.0) | changes)
    numbers = {n: jnp.asarray(float(x)) for n, x in values.items()}
    return SingleTorsionPendulum(
        drive=double.drive,
        spring=double.spring,
        bearing=double.bearing,
        B1=double.B1,
        terms=(Applied(effect(id), numbers),),
    )


def frequency(ts: np.ndarray, x: np.ndarray) -> float:
    """Of an oscillation about zero [rad/s], from its first and last crossing upwards."""
    up = np.flatnonzero((x[:-1] < 0.0) & (x[1:] >= 0.0))
    crossings = ts[up] - x[up] * np.diff(ts)[up] / (x[up + 1] - x[up])
    return 2.0 * np.pi * (crossings.size - 1) / (crossings[-1] - crossings[0])


def spring_end(g: float, theta, A: float = 0.18) -> np.ndarray:
    """f_e at a phase of the drive."""
    t = jnp.asarray(theta) / BENCH["omega"]
    model = bench("drive_backlash", {"g": g}, omega=BENCH["omega"], A=A)
    return np.asarray(model.motion(t, tuple(jnp.zeros((4, t.size)))).f)


# wider than half the drive's way, it is never passed in one sense
@pytest.mark.parametrize("g", [0.01, 0.02, 0.1, 0.2])
def test_backlash_is_the_play_of_the_sine(g):
    theta = np.linspace(0.0, 40.0, 40_001)
    expected = play(0.18 * np.sin(theta), g)
    turned = theta > np.pi / 2  # before, the formula takes the sine for an old one
    found = spring_end(g, theta)
    # but for what lets it have a derivative at null
    np.testing.assert_allclose(found[turned], expected[turned], atol=0.02 * g)
    assert np.abs(found - 0.18 * np.sin(theta)).max() == pytest.approx(min(g, 0.18), rel=1e-3)


def test_backlash_has_a_dead_zone():
    theta = np.linspace(np.pi / 2, 3 * np.pi / 2, 10_001)
    f, arm = spring_end(0.02, theta), 0.18 * np.sin(theta)
    stands = np.abs(np.diff(f)) < 2e-3 * np.abs(np.diff(arm))
    went = -np.diff(arm)[stands].sum()
    assert went == pytest.approx(2 * 0.02, rel=1e-2)
    # and then goes along
    np.testing.assert_allclose(np.diff(f)[~stands][1:], np.diff(arm)[~stands][1:], rtol=1e-3)


def test_a_motor_at_rest_stays_in_its_gap():
    np.testing.assert_array_equal(spring_end(0.02, np.linspace(0.0, 9.0, 50), A=0.0), 0.0)


def test_a_bearing_of_bristles_is_a_spring_before_it_slides():
    z0, ts = 0.01, np.linspace(0.0, 1.0, 1001)
    values, y0 = {"a": 1.0, "z0": z0}, [0.0, 0.0, 2e-3, 0.0, 0.0]
    stiff = K + BENCH["M1"] / z0
    found = angles(alone("bearing_presliding", values), ts, y0)[:, 0]
    assert frequency(ts, found) == pytest.approx(np.sqrt(stiff / B1), rel=0.02)
    # a part only, beside a dry friction that holds: it stays where it stopped
    held = angles(alone("bearing_presliding", values | {"a": 0.5}), ts, y0)[:, 0]
    assert np.abs(held).max() < 0.05 * np.abs(found).max()


def test_a_contact_of_bristles_is_a_spring_before_it_slides():
    # a column as good as fixed
    z0, ts, heavy = 0.01, np.linspace(0.0, 0.5, 1001), 1e6
    model = bench("contact_presliding", {"a": 1.0, "z0": z0}, A=0.0, B1=heavy)
    found = angles(model, ts, [0.0, 0.0, 0.0, 2e-3, 0.0])[:, 1]
    assert frequency(ts, found) == pytest.approx(np.sqrt(BENCH["Ts1"] / z0 / B2), rel=0.02)


def test_bristles_let_a_column_slide_against_its_friction():
    # all of the friction on bristles, a large swing: the motion in plain numbers
    z0, ts = 0.003, np.linspace(0.0, 1.0, 1001)

    def f(t, y):
        phi, v, z = y
        return [v, (-K * phi - BENCH["c1"] * v - BENCH["M1"] * z / z0) / B1, v - abs(v) * z / z0]

    expected = solve_ivp(
        f, (0.0, 1.0), [0.6, 0.0, 0.0], t_eval=ts, rtol=1e-10, atol=1e-12, max_step=5e-4
    ).y[0]
    model = alone("bearing_presliding", {"a": 1.0, "z0": z0})
    found = angles(model, ts, [0.6, 0.0, 0.0, 0.0, 0.0])[:, 0]
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-6)


def test_each_turn_of_a_rubbing_spring_takes_its_loop():
    a, z0 = 0.1, 0.03
    ts = np.linspace(0.0, 2.0, 8001)
    model = alone("spring_hysteresis", {"a": a, "z0": z0}, c1=0.0, M1=0.0)
    phi = angles(model, ts, [0.6, 0.0, 0.0, 0.0, 0.0])[:, 0]
    inner = np.flatnonzero(np.diff(np.sign(np.diff(phi)))) + 1
    ends = np.abs(phi[inner])
    assert ends.size > 10
    for one, two in itertools.pairwise(ends[1:]):
        mean = 0.5 * (one + two)
        half_a_loop = 2.0 * a * K * z0 * (mean - z0 * np.tanh(mean / z0))
        assert 0.5 * K * (one**2 - two**2) == pytest.approx(half_a_loop, rel=0.03)


def test_a_cable_stiffens_small_swings_only():
    a, z0, ts = 0.1, 0.05, np.linspace(0.0, 2.0, 2001)
    model = alone("column_cable", {"a": a, "z0": z0}, c1=0.0, M1=0.0)
    small, large = (
        frequency(ts, angles(model, ts, [0.0, 0.0, v, 0.0, 0.0])[:, 0]) for v in (2e-3, 20.0)
    )
    assert small == pytest.approx(np.sqrt((K + a) / B1), rel=5e-3)
    assert large == pytest.approx(np.sqrt(K / B1), rel=5e-3)


@pytest.mark.parametrize("omega", [10.0, 19.0, 25.0, 30.0, 33.0, 45.0])
def test_a_soft_base_resonates(omega):
    # all linear: the amplitudes of both angles solve two equations
    a, W, zeta, c1 = 0.3, 5.0, 0.1, 0.02
    w, s = 2.0 * np.pi * W, 1j * omega
    pull = K + c1 * s  # of spring and bearing, on the column's angle
    equations = np.array(
        [[B1 * s**2 + pull, B1 * s**2], [-a * pull / B1, s**2 + 2 * zeta * w * s + w**2]]
    )
    phi, psi = np.linalg.solve(equations, np.array([K, -a * K / B1]) * 0.1)
    model = alone(
        "base_compliance", {"a": a, "W": W, "zeta": zeta}, A=0.1, omega=omega, c1=c1, M1=0.0
    )
    ts = np.linspace(0.0, 6.0, 3001)
    late = ts > 4.0
    found = angles(model, ts)[late, 0]
    waves = np.exp(s * ts[late])
    np.testing.assert_allclose(found, (phi * waves).imag, atol=1e-5)
    assert abs(psi) > 1e-3
    # without its base the column does something else
    alone_at = 0.1 * K / (B1 * s**2 + pull)
    assert abs(phi - alone_at) > (0.3 if omega > 25.0 else 0.005) * abs(alone_at)
