"""Each law against its formula in the paper, written anew in numpy."""

import math

import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from tests.reference import BENCH, PAPER, instant, right_hand_side
from tp_jax.model import (
    Bearing,
    Contact,
    DoubleTorsionPendulum,
    LinearSpring,
    PiecewiseCubicDrive,
    SineDrive,
    presets,
    smooth_sign,
)
from tp_jax.model.friction import rising_sign
from tp_jax.model.parameters import BASE, BY_NAME, NUISANCES, REFERENCE_B1

V = np.array([-30.0, -1.0, -1e-3, -1e-9, 0.0, 1e-12, 1e-4, 0.2, 7.0])
angle = st.floats(-2.0, 2.0)
speed = st.floats(-20.0, 20.0)


def test_equation_3b():
    t = np.linspace(0.0, 3.0, 31)
    drive = SineDrive(A=0.3, omega=7.0, offset=0.2)
    np.testing.assert_allclose(drive.phase(t), 7.0 * t + 0.2)
    np.testing.assert_allclose(drive.angle(t, drive.phase(t)), 0.3 * np.sin(7.0 * t + 0.2))
    assert drive.amplitude == 0.3


def test_a_measured_drive_is_the_spline_through_its_samples():
    knots = np.linspace(0.0, 2.0, 21)
    spline = CubicSpline(knots, np.sin(3.0 * knots))
    drive = PiecewiseCubicDrive(gain=0.5, offset=0.1, knots=knots, coefficients=spline.c)
    for t in (0.0, 0.05, 1.0, 1.234, 2.0):
        value = drive.angle(jnp.asarray(t), drive.phase(jnp.asarray(t)))
        assert value == pytest.approx(0.5 * spline(t) + 0.1, abs=1e-14)


def test_equation_5():
    law = Bearing(c1=2.0, M1=3.0, eps=1000.0)
    expected = 2.0 * V + 3.0 * (2.0 / np.pi) * np.arctan(1000.0 * V)
    np.testing.assert_allclose(law.torque(V), expected, rtol=1e-14)
    np.testing.assert_allclose(law.viscous(V) + law.dry(V), expected, rtol=1e-14)


def test_equation_6():
    law = Contact(Tv=1.0, Ts1=2.0, Ts2=4.0, Tst=0.5, T0=10.0, eps=1000.0)
    with_Ts2 = (
        1.0 * V
        + 2.0 * (2.0 / np.pi) * np.arctan(1000.0 * V)
        + 4.0 * (1.0 - np.sign(np.abs(V)))
        + 0.5 * (1.0 - np.exp(-10.0 * np.abs(V))) * np.sign(V)
    )
    np.testing.assert_allclose(law.printed_torque(V), with_Ts2, rtol=1e-13, atol=1e-15)
    np.testing.assert_allclose(law.torque(V), with_Ts2 - 4.0 * (V == 0.0), rtol=1e-13, atol=1e-15)
    np.testing.assert_allclose(law.torque(V), law.viscous(V) + law.dry(V), rtol=1e-14)


def test_Ts2_acts_at_rest_only_and_the_same_way_for_both_directions():
    law = Contact(Tv=1.0, Ts1=2.0, Ts2=4.0, Tst=0.5, T0=10.0, eps=1000.0)
    moving = np.array([-1e-300, 1e-300, -1.0, 1.0])
    np.testing.assert_array_equal(law.printed_torque(moving), law.torque(moving))
    assert law.printed_torque(jnp.zeros(())) == 4.0
    assert law.torque(jnp.zeros(())) == 0.0


def test_smooth_signs_are_odd_and_end_at_one():
    for sign in (smooth_sign, rising_sign):
        np.testing.assert_allclose(sign(-V, 50.0), -sign(V, 50.0))
        assert sign(jnp.asarray(1e9), 50.0) == pytest.approx(1.0)
    # all digits are kept where a stuck body creeps
    assert rising_sign(jnp.asarray(1e-14), 10.0) == pytest.approx(1e-13, rel=1e-10)


def test_spring():
    spring = LinearSpring(3.0)
    np.testing.assert_allclose(spring.torque(V), 3.0 * V)
    np.testing.assert_allclose(spring.energy(V), 1.5 * V**2)


@pytest.mark.parametrize(("name", "p"), [("paper-5.1", PAPER), ("bench", BENCH)])
@given(t=st.floats(0.0, 10.0), phi1=angle, phi2=angle, v1=speed, v2=speed)
def test_equations_16(name, p, t, phi1, phi2, v1, v2):
    y = [phi1, phi2, v1, v2]
    field = presets.get(name).vector_field(jnp.asarray(t), jnp.asarray(y))
    np.testing.assert_allclose(field, right_hand_side(p)(t, y), rtol=1e-11, atol=1e-11)


@given(t=st.floats(0.0, 10.0), phi1=angle, phi2=angle, v1=speed, v2=speed)
def test_equations_16_as_printed_hold(t, phi1, phi2, v1, v2):
    # put back into (16a) and (16b), term by term
    m = presets.get("paper-5.1").motion(jnp.asarray(t), (phi1, phi2, v1, v2))
    q = instant(PAPER, t, [phi1, phi2, v1, v2])
    left = 20.0 * m.a1 - 100.0 * (math.pi / 6 * math.sin(0.5 * t) - phi1)
    assert left == pytest.approx(-q.ML + 2.0 * q.MT, rel=1e-9, abs=1e-9)
    assert 1.0 * (m.a1 + m.a2) == pytest.approx(-q.MT, rel=1e-9, abs=1e-9)
    assert m.bearing == pytest.approx(q.ML)
    assert m.contact == pytest.approx(q.MT)


def test_readings_are_the_angles_and_their_zeros():
    model = presets.get("bench")
    y = (jnp.asarray(0.1), jnp.asarray(0.2), jnp.asarray(3.0), jnp.asarray(4.0))
    assert model.readings(jnp.zeros(()), y) == (0.1, 0.2)


@pytest.mark.parametrize(("name", "p"), [("paper-5.1", PAPER), ("bench", BENCH)])
def test_presets_hold_what_is_stated(name, p):
    assert presets.values(name) == pytest.approx(p)
    model = presets.get(name)
    assert isinstance(model, DoubleTorsionPendulum)
    assert model.reaction == (2.0 if name == "paper-5.1" else 1.0)
    assert model.bearing.eps == model.contact.eps == (1000.0 if name == "paper-5.1" else 5e4)


def test_presets_by_name():
    assert presets.names() == ("paper-5.1", "paper-5.1-start", "bench")
    start = dict(
        B1=22,
        B2=11,
        k=10,
        A=math.pi / 4,
        omega=0.5,
        c1=5,
        M1=2,
        Tv=0.1,
        Ts1=3,
        Ts2=1,
        Tst=0.2,
        T0=1000,
        eps=1000,
        reaction=2,
    )
    assert presets.values("paper-5.1-start") == pytest.approx(start)
    assert presets.paper_5_1.B1 == 20.0
    with pytest.raises(KeyError, match=r"bench"):
        presets.get("nothing")
    with pytest.raises(AttributeError, match="nothing"):
        presets.nothing  # noqa: B018


@pytest.mark.parametrize("spec", [*BASE, *NUISANCES], ids=lambda spec: spec.name)
def test_coordinates_go_there_and_back(spec):
    value = spec.typical if spec.lower < spec.typical < spec.upper else 0.5 * spec.upper
    u = float(spec.to_coordinate(value))
    assert spec.from_coordinate(u) == pytest.approx(value)
    slope = (spec.from_coordinate(u + 1e-6) - spec.from_coordinate(u - 1e-6)) / 2e-6
    assert spec.slope(value) == pytest.approx(float(slope), rel=1e-6)


def test_bounds_follow_the_inertia():
    spec = BY_NAME["Ts1"].scaled(5.0 * REFERENCE_B1)
    assert spec.upper == pytest.approx(5.0 * BY_NAME["Ts1"].upper)
    assert spec.typical == pytest.approx(5.0 * BY_NAME["Ts1"].typical)
    assert BY_NAME["A"].scaled(5.0) == BY_NAME["A"]
