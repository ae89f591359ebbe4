"""States of windows by themselves: a body at rest, and where a window goes on from."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tp_jax.estimation.prepared_campaign import prepare_campaign
from tp_jax.estimation.start import initial_values
from tp_jax.estimation.variable_projection import fit
from tp_jax.estimation.window_states import costs, rejoin, settle
from tp_jax.recordings import Campaign, Recording

RATE, DURATION, SIGMA = 250.0, 8.0, 1.8e-3
TRUTH = {"k": 311.0, "c1": 1.39, "M1": 2.14}


def decay(release, seed):
    """A column that comes to rest, per unit of its inertia; friction sharp to 0.1 mrad/s."""

    def rates(t, y):
        friction = TRUTH["M1"] * np.tanh(y[1] / 1e-4)
        return [y[1], -TRUTH["k"] * y[0] - TRUTH["c1"] * y[1] - friction]

    t = np.arange(round(DURATION * RATE) + 1) / RATE
    run = solve_ivp(rates, (0.0, DURATION), [release, 0.0], t_eval=t, rtol=1e-8, method="LSODA")
    noise = SIGMA * np.random.default_rng(seed).normal(size=t.size)
    return Recording.from_arrays(t, run.y[0] + noise, name=f"decay-{seed}")


@pytest.fixture(scope="module")
def setting():
    runs = [decay(release, i) for i, release in enumerate((1.1, -0.9))]
    return prepare_campaign(Campaign.from_arrays(runs, model="single"), effects=())


@pytest.fixture(scope="module")
def values(setting):
    values = initial_values(setting).replace(TRUTH)
    return values.replace({"eps1": setting.sharpest, "eps2": setting.sharpest})


def settled(problem, values, states):
    lin = problem.linearise(values, states, ())
    return settle(problem, values, states, lin, ())


def moving_at_rest(problem, values):
    """States of which some move where the column is at rest, each in a minimum of its own.

    Returns:
        The good ones, settled; those windows; the others, settled.
    """
    good = settled(problem, values, problem.initial_states(values))
    swing = np.ptp(good.lin.states[:, :, 0], axis=1)
    rest = np.flatnonzero(swing < 1e-3)
    states = good.states.copy()
    states[rest, 2] = 0.3
    return good, rest, settled(problem, values, states)


def test_a_window_at_rest_begins_where_the_one_before_it_ended(setting, values):
    problem = setting.problem(setting.horizons[-1])
    good, rest, stuck = moving_at_rest(problem, values)
    above = costs(stuck.lin) - costs(good.lin)
    wrong = rest[above[rest] > 20.0]
    assert wrong.size  # or there is nothing to mend
    gain, passes = rejoin(problem, values, stuck.states, stuck.lin, ())
    assert gain > 0.9 * above[wrong].sum()
    assert passes < 1.5
    np.testing.assert_allclose(costs(stuck.lin)[wrong], costs(good.lin)[wrong], atol=2.0)
    again = problem.linearise(values, stuck.states, ())
    np.testing.assert_allclose(costs(stuck.lin), costs(again), rtol=1e-6)


def test_nothing_begins_anew_where_all_is_well(setting, values):
    problem = setting.problem(setting.horizons[-1])
    good = settled(problem, values, problem.initial_states(values))
    before = good.states.copy()
    gain, passes = rejoin(problem, values, good.states, good.lin, ())
    assert gain < 2.0
    assert passes < 0.5
    if not gain:
        np.testing.assert_array_equal(good.states, before)


def test_a_fit_ends_as_low_as_from_good_states(setting, values):
    """Seen on a rig with nothing hidden: three such windows passed for friction before sliding."""
    problem = setting.problem(setting.horizons[-1])
    good, _, stuck = moving_at_rest(problem, values)
    how = dict(unknowns=setting.unknowns(), priors=setting.priors(), relative=1e-7)
    best, found = (fit(problem, values, states=s.states, **how) for s in (good, stuck))
    assert found.converged, found.message
    assert found.cost < best.cost + 3.0
