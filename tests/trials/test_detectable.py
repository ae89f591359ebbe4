"""Minimum detectable sizes, measured on the rig without a model."""

import numpy as np
import pytest

from tp_jax.rig import BENCH, VirtualRig
from trials import detectable
from trials.detectable import (
    least_noncentrality,
    minimum_detectable,
    needed,
    noncentrality,
)
from trials.projection import FREE, Bench
from trials.restart import plain_window

PLAN = ({"release": 0.7}, {"omega": 11.0}, {"omega": 14.0})
SHORT = Bench(BENCH, PLAN, duration=3.0, rate=100.0)


def test_a_restart_goes_on_as_before():
    rig = VirtualRig()
    for run in PLAN:
        rig.start(**run)
        for start in (0.0, 0.83, 1.7):
            state = rig.motion(start)
            offsets = np.linspace(0.0, 0.5, 20)
            again = plain_window(BENCH, run.get("omega"), state, start, offsets.tolist())
            went = [rig.motion(start + x)[:2] for x in offsets.tolist()]
            np.testing.assert_allclose(again, went, atol=2e-7)


def test_needed_noncentrality():
    # (z(0.05 / tests / 2) + z(0.05))^2 for one amplitude
    assert needed(SHORT, "spring_asymmetry") == pytest.approx(23.8, abs=0.5)
    assert needed(SHORT, "column_tilt") > needed(SHORT, "spring_asymmetry")
    # what nobody looks for must be larger
    assert needed(SHORT, "motor_stall") > 5 * needed(SHORT, "spring_asymmetry")


def test_small_effects_show_in_proportion():
    one, two = (noncentrality(SHORT, "spring_asymmetry", (a,), {}) for a in (0.01, 0.02))
    assert two / one == pytest.approx(4.0, rel=0.1)


def test_no_effect_shows_nothing():
    assert noncentrality(SHORT, "spring_asymmetry", (0.0,), {}) < 1e-3


def test_what_other_numbers_explain_as_well():
    # a reaction other than the whole is another B2 and other friction
    known = Bench(BENCH, PLAN, 3.0, 100.0, free=tuple(n for n in FREE if n != "B2"))
    hidden = noncentrality(SHORT, "reaction_factor", (0.01,), {})
    assert hidden < 0.01 * noncentrality(known, "reaction_factor", (0.01,), {})


def test_detectable_size_is_where_it_is_needed():
    factor = minimum_detectable(SHORT, "contact_wear", (0.4,), {})
    found = noncentrality(SHORT, "contact_wear", (0.4 * factor,), {})
    assert found == pytest.approx(needed(SHORT, "contact_wear"), rel=0.5)


def test_what_never_shows():
    assert minimum_detectable(SHORT, "drive_steps", (1.0,), {}) > 1.0


def test_the_least_detectable_direction():
    # near phi1 = 0 a friction a cos(phi1) is hardly other than a larger M1
    size, shapes = 0.3, {"bearing_position.n": 1.0}
    any_way = [(size, 0.0), (0.0, size), (0.6 * size, 0.8 * size)]
    shown = [noncentrality(SHORT, "bearing_position", sizes, shapes) for sizes in any_way]
    least = least_noncentrality(SHORT, "bearing_position", any_way[2], shapes)
    assert 0.0 < least <= 1.1 * min(shown)
    assert shown[0] < shown[1]


def test_a_run_that_has_next_to_nothing_of_it_does_not_say_how_it_shows(monkeypatch):
    """What such a run shows comes of the others, through the numbers that all runs share."""
    found, squares = np.array([10.0, 12.0, 5.0]), np.array([1.0, 1.0, 1e-6])
    monkeypatch.setattr(detectable, "noncentralities", lambda *_: (found, squares))
    least = detectable.least_noncentrality(None, "contact_repeatability", (1.0,), {})
    assert least == pytest.approx(10.0 * squares.sum())
