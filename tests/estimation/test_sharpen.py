"""The friction's smoothing: what a search needs, and what is left of it in what is found."""

import dataclasses

import numpy as np
import pytest

import tp_jax as tp
from tp_jax.estimation import sharpen
from tp_jax.estimation.prepared_campaign import prepare_campaign
from tp_jax.estimation.schedule import fit_over_schedule
from tp_jax.estimation.sharpen import fit_with_sharp_friction
from tp_jax.estimation.start import initial_values
from tp_jax.model.parameters import DEFAULT_EPS, PAPER_EPS, SHARPEST_EPS
from tp_jax.rig import RigParameters, make_campaign

pytestmark = pytest.mark.slow

TRUTH = RigParameters()


@pytest.fixture(scope="module")
def fitted(tmp_path_factory):
    """A rig with hard friction and good sensors, fitted with the search's smoothing."""
    folder = tmp_path_factory.mktemp("rig") / "rig"
    make_campaign(folder, TRUTH, runs=3, duration=5.0, noise=1e-4, bits=20, seed=1)
    setting = prepare_campaign(tp.load_campaign(folder), effects=())
    return setting, fit_over_schedule(setting, initial_values(setting), setting.unknowns())


def test_what_is_found_is_nearer_to_hard_friction(fitted):
    setting, before = fitted
    after = fit_with_sharp_friction(setting, before)
    assert before.values.get("eps2") == DEFAULT_EPS
    assert after.values.get("eps1") == after.values.get("eps2") == SHARPEST_EPS
    assert after.cost < before.cost
    assert after.unknowns == before.unknowns
    for name in ("Ts1", "Tst"):
        miss = [abs(f.values.get(name) / getattr(TRUTH, name) - 1.0) for f in (before, after)]
        assert miss[1] < 0.5 * miss[0], (name, miss)
    assert fit_with_sharp_friction(setting, after) is after


def test_the_paper_keeps_its_smoothing(fitted):
    setting, before = fitted
    printed = dataclasses.replace(setting, model="paper")
    assert printed.eps == printed.sharpest == PAPER_EPS
    assert fit_with_sharp_friction(printed, before) is before


@pytest.mark.parametrize("cost", [np.inf, 1e9])
def test_a_kink_is_not_taken(fitted, monkeypatch, cost):
    setting, before = fitted
    monkeypatch.setattr(sharpen, "fit", lambda *_, **__: dataclasses.replace(before, cost=cost))
    assert fit_with_sharp_friction(setting, before) is before


def test_bounds_that_are_not_the_settings(fitted, monkeypatch):
    setting, before = fitted
    asked = []

    def fit(*_, bounds, **__):
        asked.append(bounds)
        return before

    monkeypatch.setattr(sharpen, "fit", fit)
    fit_with_sharp_friction(setting, before)
    fit_with_sharp_friction(setting, before, bounds={"k": (0.0, 1.0)})
    own = {"k": (0.0, 1.0)}
    assert asked == [setting.bounds, setting.bounds, own, own]


def test_the_way_is_gone_in_two_steps(fitted, monkeypatch):
    """In one a fit may end far above the least sum of squares, beyond kinks that it cannot pass."""
    setting, before = fitted
    steps = []

    def fit(problem, values, unknowns, states, **how):
        steps.append((values.get("eps1"), values.get("eps2")))
        return sharpened(problem, values, unknowns, states, **how)

    sharpened = sharpen.fit
    monkeypatch.setattr(sharpen, "fit", fit)
    fit_with_sharp_friction(setting, before)
    between = np.sqrt(DEFAULT_EPS * SHARPEST_EPS)
    assert steps == [(pytest.approx(between),) * 2, (SHARPEST_EPS,) * 2]
