"""Networks of sliders and the play operator against what is known of them."""

import itertools

import numpy as np
import pytest

from tp_jax.rig.effects.maxwell_slip import ELEMENTS, MaxwellSlip
from tp_jax.rig.effects.play import Play


def along(net, path):
    out = []
    for x in path:
        out.append(net.torque(x))
        net.begin(x)
    return np.array(out)


def line(*corners, n=400):
    """A path that goes straight from corner to corner."""
    return np.concatenate([np.linspace(a, b, n) for a, b in itertools.pairwise(corners)])


def test_full_slip_is_one_either_way():
    net = MaxwellSlip(0.1)
    assert along(net, line(0.0, 5.0))[-1] == pytest.approx(1.0, abs=1e-14)
    assert along(net, line(5.0, -5.0))[-1] == pytest.approx(-1.0, abs=1e-14)


def test_branch_from_full_slip_is_that_of_a_dahl_state():
    z0 = 0.1
    net = MaxwellSlip(z0)
    along(net, line(0.0, 5.0))
    back = np.linspace(0.0, 3.0 * z0, 300)
    # Dahl's z' = v - |v| z / z0 from z = z0 on
    dahl = 2.0 * np.exp(-back / z0) - 1.0
    np.testing.assert_allclose(along(net, 5.0 - back), dahl, atol=1.0 / ELEMENTS)


def test_initial_stiffness_is_that_of_all_elements():
    net = MaxwellSlip(0.1)
    assert net.torque(1e-6) / 1e-6 == pytest.approx(2.0 / 0.1, rel=0.1)


def test_loops_close_and_take_energy():
    net = MaxwellSlip(0.1)
    path = line(0.0, 0.05, -0.05, 0.05, -0.05)
    torque = along(net, path)
    np.testing.assert_allclose(torque[400:800], torque[1200:1600], atol=1e-12)
    taken = np.sum(0.5 * (torque[800:][1:] + torque[800:][:-1]) * np.diff(path[800:]))
    assert taken > 1e-4


def test_no_kink_before_it_is_told():
    net = MaxwellSlip(0.1)
    far = net.to_kink(0.0)
    x = np.linspace(0.0, far, 50)
    torque = np.array([net.torque(each) for each in x])
    np.testing.assert_allclose(np.diff(torque, 2), 0.0, atol=1e-12)
    net.begin(far)
    assert net.to_kink(far) > 1e-11
    assert net.torque(far + 1e-3) - net.torque(far) < torque[-1] / far * 1e-3


def test_play_follows_only_at_the_end_of_its_gap():
    play = Play(0.1)
    out = []
    for x in line(0.0, 1.0, 0.0):
        out.append(play.follow(x))
        play.begin(x)
    assert out[399] == pytest.approx(0.9)
    assert out[-1] == pytest.approx(0.1)
    assert out[420] == pytest.approx(0.9)
