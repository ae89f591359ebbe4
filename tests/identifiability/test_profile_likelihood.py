"""Profiles: parabolas where the likelihood is one, open ends where the data do not close them."""

import dataclasses

import numpy as np
import pytest

from tests.reference import BENCH
from tp_jax.estimation.prepared_campaign import prepare_campaign
from tp_jax.estimation.variable_projection import fit as fit_windows
from tp_jax.identifiability.information import information
from tp_jax.identifiability.profile_likelihood import profiles


@pytest.fixture(scope="module")
def found(fit, setting):
    return {p.name: p for p in profiles(fit, setting, ("k", "Tst", "T0"))}


def test_an_interval_is_the_parabolas_where_the_profile_is_one(fit, setting, found):
    known = information(fit, setting)
    sd = known.sd[known.names.index("k")]
    p = found["k"]
    half = np.sqrt(p.level) * sd
    assert p.best == pytest.approx(fit.values.get("k"), abs=0.05 * sd)
    np.testing.assert_allclose(p.ci95, (p.best - half, p.best + half), atol=0.1 * half)
    assert p.identifiable
    assert p.level >= 3.84


def test_an_interval_ends_where_the_level_is_reached(found):
    for p in found.values():
        inside = [
            (low is None or x > low) and (high is None or x < high)
            for x in p.values
            for low, high in [p.ci95]
        ]
        # nothing inside is rejected, nothing outside is not; the ends are read off within a tenth
        assert (p.drops[inside] < 1.25 * p.level).all()
        assert (p.drops[~np.array(inside)] > 0.75 * p.level).all()
        assert p.drops.min() == 0.0
        assert (np.diff(p.values) >= 0.0).all()


def test_the_truth_lies_within(found):
    # of one campaign: the coverage of many is what scripts/coverage looks at
    for name, p in found.items():
        low, high = p.ci95
        assert low is None or low < BENCH[name] * 1.5
        assert high is None or high > BENCH[name] / 1.5


def test_to_dict(found):
    table = found["Tst"].to_dict()
    assert table["ci95"] == list(found["Tst"].ci95)
    assert len(table["values"]) == len(table["drops"])


def test_a_rider_that_never_slips_leaves_t0_open(setting):
    """The column swings so little that the contact always sticks."""
    campaign = setting.campaign
    quiet = tuple(r for r in campaign.recordings if r.omega == 13.09)
    calm = tuple(
        dataclasses.replace(r, phi1=0.02 * r.phi1, phi2=0.0 * r.phi2 + 1e-5 * np.sin(40.0 * r.t))
        for r in quiet
    )
    own = prepare_campaign(dataclasses.replace(campaign, recordings=calm), effects=())
    values = _bench_values(own)
    problem = own.problem(own.horizons[-1])
    fitted = fit_windows(problem, values, own.unknowns(), priors=own.priors())
    (p,) = profiles(fitted, own, ("T0",))
    assert not p.identifiable
    assert p.ci95[1] is None


def test_an_unknown_name_is_refused(fit, setting):
    with pytest.raises(ValueError, match="'Ts2'"):
        profiles(fit, setting, ("Ts2",))


def _bench_values(setting):
    from tests.rigs import synthetic_values

    return synthetic_values(setting)
