"""Windows that no fit has seen, under sharp friction: states from the readings alone."""

import numpy as np
import pytest

from tests.reference import BENCH, reference
from tp_jax.estimation.from_readings import fit_from_readings
from tp_jax.estimation.prepared_campaign import prepare_campaign
from tp_jax.estimation.start import initial_values
from tp_jax.estimation.variable_projection import fit
from tp_jax.estimation.window_states import costs
from tp_jax.recordings import Campaign, Recording

RATE, DURATION = 200.0, 8.0
SIGMA = 1e-2, 4e-4  # rad: of the column, whose speed is then hard to tell, and of the rider
RIG = BENCH | dict(
    B2=5.1e-4, k=0.153, A=0.22, c1=2.4e-3, M1=5.1e-3, Tv=8.8e-5, Ts1=7.2e-3, Tst=1.1e-3, T0=1.29
)
NUMBERS = ("B2", "k", "A", "c1", "M1", "Tv", "Ts1", "Tst", "T0")


def motion(omega):
    """A run from a release (n, 4), whose rider sticks and slides in turns."""
    t = np.arange(round(DURATION * RATE)) / RATE
    rig = RIG | {"omega": omega, "eps": 2e5}
    return t, reference(rig, t, (0.3, 0.0, 0.0, 0.0), rtol=1e-8, atol=1e-10)


@pytest.fixture(scope="module")
def runs():
    return {omega: motion(omega) for omega in (4.2, 8.9, 12.1, 6.0)}


@pytest.fixture(scope="module")
def setting(runs):
    random = np.random.default_rng(5)
    found = []
    for omega, (t, y) in runs.items():
        phi1, phi2 = (y[:, :2] + np.array(SIGMA) * random.standard_normal((t.size, 2))).T
        found.append(Recording.from_arrays(t, phi1, phi2, omega=omega, name=f"{omega:g}"))
    return prepare_campaign(Campaign.from_arrays(found, B1=RIG["B1"]), effects=())


def test_they_end_as_low_as_from_the_true_states(setting, runs):
    sharp = {"eps1": setting.sharpest, "eps2": setting.sharpest}
    values = initial_values(setting).replace({n: RIG[n] for n in NUMBERS} | sharp)
    problem = setting.problem(1.0)
    w, motions = problem.windows, [y for _, y in runs.values()]
    true = np.array([motions[r][i] for r, i in zip(w.recording, w.first, strict=True)])
    how = dict(max_iterations=30, kinks=True)
    best = fit(problem, values, (), true, **how)
    alone = fit(problem, values, (), **how)
    found = fit_from_readings(problem, values, eps=setting.eps)
    best, alone, end = (costs(f.linearisation) for f in (best, alone, found))
    assert (alone > best + 20.0).any()  # or there is nothing to mend
    assert found.values.get("eps2") == setting.sharpest
    assert (end < best + 5.0).all()
