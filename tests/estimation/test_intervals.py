"""Intervals of fitted numbers."""

import dataclasses

import numpy as np

from tests.rigs import synthetic_campaign, synthetic_values
from tp_jax.estimation.intervals import intervals
from tp_jax.estimation.prepared_campaign import prepare_campaign
from tp_jax.estimation.variable_projection import fit


def test_what_the_recordings_do_not_tell_is_not_identified():
    """Without a row of information no interval is narrow, and the others stay as they are."""
    setting = prepare_campaign(synthetic_campaign(duration=2.0), effects=())
    problem = setting.problem(setting.horizons[-1])
    found = fit(problem, synthetic_values(setting), setting.unknowns(), max_iterations=3)
    i = [u.name for u in found.unknowns].index("M1")
    told = found.eliminated
    g, H = told.g.copy(), told.H.copy()
    assert (told.to[:, i] == i).all()  # of the whole campaign
    g[:, i], H[:, i], H[:, :, i] = 0.0, 0.0, 0.0
    blind = dataclasses.replace(found, eliminated=dataclasses.replace(told, g=g, H=H))
    before, after = intervals(found, setting), intervals(blind, setting)
    assert before["M1"]["identifiable"]
    assert not after["M1"]["identifiable"]
    low, high = after["M1"]["ci95"]
    assert high - low > 100.0 * np.diff(before["M1"]["ci95"])[0]
    assert after["k"]["identifiable"]


def test_an_interval_of_a_value_beyond_the_usual_bounds_holds_it():
    """`--bound` may be wider than the usual one, and a shape constant goes beyond its grid."""
    setting = prepare_campaign(synthetic_campaign(duration=2.0), effects=())
    problem = setting.problem(setting.horizons[-1])
    found = fit(problem, synthetic_values(setting), setting.unknowns(), max_iterations=1)
    free = np.zeros(len(found.unknowns), bool)
    for name, value in (("T0", 2000.0), ("k", 1e5)):
        moved = dataclasses.replace(
            found, values=found.values.replace({name: value}), at_bound=free
        )
        low, high = intervals(moved, setting)[name]["ci95"]
        assert low <= value <= high
