"""Draws for ArviZ have the intervals and the correlations of the fit."""

import importlib
import warnings

import numpy as np
import pytest

from tp_jax.errors import InputError
from tp_jax.model.parameters import BY_NAME, REFERENCE_B1
from tp_jax.report.arviz_export import _drawn, to_arviz

NAMES = ("arviz", "arviz_base")


def parameter(value, ci95, unit="1", identifiable=True):
    return {"value": value, "unit": unit, "ci95": ci95, "identifiable": identifiable}


FOUND = {
    "campaign": "case",
    "model": "newton",
    "parameters": {
        "k": parameter(0.45, [0.44, 0.46], "N m/rad"),
        "Ts1": parameter(0.01, [0.01 / 1.5, 0.015], "N m"),
        "M1": parameter(0.001, [0.0, 0.004], "N m"),
        "T0": parameter(4.0, [1e-9, 1e9], "s/rad", identifiable=False),
        "A": parameter(0.3, [0.3, None], "rad"),
        "Ts2": parameter(0.0, None, "N m"),
    },
    "correlation": {
        "names": ["Ts1", "k", "T0"],
        "matrix": [[1.0, -0.8, 0.1], [-0.8, 1.0, 0.0], [0.1, 0.0, 1.0]],
    },
}


@pytest.fixture(params=NAMES)
def arviz(request, monkeypatch):
    """Each of the packages in turn, as if it were the only one."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of its own age
        module = pytest.importorskip(request.param, reason="needs pip install arviz")
    monkeypatch.setattr("tp_jax.report.arviz_export._arviz", lambda: module)
    return module


def test_draws_have_the_intervals(arviz):
    tree = to_arviz(FOUND, draws=5000, chains=4)
    posterior = tree["posterior"]
    assert set(posterior.data_vars) == {"k", "Ts1", "M1"}
    assert dict(posterior.sizes) == {"chain": 4, "draw": 5000}
    k, Ts1, M1 = (posterior[name].values.ravel() for name in ("k", "Ts1", "M1"))
    np.testing.assert_allclose(np.quantile(k, [0.025, 0.975]), [0.44, 0.46], atol=5e-4)
    np.testing.assert_allclose(
        np.quantile(Ts1, [0.025, 0.5, 0.975]), [0.00667, 0.01, 0.015], rtol=0.03
    )
    assert M1.min() == 0.0
    assert np.quantile(M1, 0.975) == pytest.approx(0.004, rel=0.05)
    assert np.corrcoef(k, np.log(Ts1))[0, 1] == pytest.approx(-0.8, abs=0.02)
    assert np.corrcoef(k, M1)[0, 1] == pytest.approx(0.0, abs=0.03)


def test_what_has_no_interval_is_constant(arviz):
    constant = to_arviz(FOUND, draws=10)["constant_data"]
    assert {name: float(np.ravel(constant[name])[0]) for name in constant.data_vars} == {
        "T0": 4.0,
        "A": 0.3,
        "Ts2": 0.0,
    }
    assert constant["A"].attrs["units"] == "rad"


def test_says_what_it_is(arviz):
    posterior = to_arviz(FOUND, draws=10)["posterior"]
    assert posterior["k"].attrs["units"] == "N m/rad"
    assert posterior.attrs["campaign"] == "case"
    assert "no sampler" in posterior.attrs["sampling"]


def test_same_seed_same_draws(arviz):
    one, again, other = (
        to_arviz(FOUND, draws=5, seed=seed)["posterior"]["k"].values for seed in (0, 0, 1)
    )
    np.testing.assert_array_equal(one, again)
    assert (one != other).all()


def test_without_correlations_draws_are_independent(arviz):
    found = {name: entry for name, entry in FOUND.items() if name != "correlation"}
    posterior = to_arviz(found, draws=5000)["posterior"]
    k, Ts1 = (posterior[name].values.ravel() for name in ("k", "Ts1"))
    assert np.corrcoef(k, Ts1)[0, 1] == pytest.approx(0.0, abs=0.03)


def test_nothing_to_draw(arviz):
    with pytest.raises(InputError, match="No parameter of this result has an interval"):
        to_arviz({"parameters": {"Ts2": parameter(0.0, None)}})
    with pytest.raises(InputError, match="one draw and one chain"):
        to_arviz(FOUND, draws=0)


def drawn(name: str, value: float, ci95: tuple[float, float]) -> np.ndarray:
    z = np.random.default_rng(0).standard_normal(40_000)
    return _drawn(value, *ci95, z, BY_NAME[name], REFERENCE_B1)


@pytest.mark.parametrize(
    ("name", "value", "ci95"),
    [
        ("M1", 0.01, (0.0093, 0.015)),  # of a ridge: neither end is a bound
        ("Ts1", 0.01, (0.0095, 0.0107)),
        ("T0", 50.0, (40.0, 90.0)),
    ],
)
def test_an_interval_that_no_bound_cuts_has_both_its_ends(name, value, ci95):
    found = drawn(name, value, ci95)
    np.testing.assert_allclose(
        np.quantile(found, [0.025, 0.5, 0.975]), [ci95[0], value, ci95[1]], rtol=0.01
    )
    assert np.unique(found).size == found.size


def test_bounds_are_not_passed():
    found = drawn("T0", 500.0, (228.0, 1000.0))
    assert found.max() == 1000.0
    assert np.quantile(found, 0.025) == pytest.approx(228.0, rel=0.02)
    assert (found == 1000.0).mean() == pytest.approx(0.0418, abs=0.005)  # of a log normal beyond
    found = drawn("M1", 0.001, (0.0, 0.004))
    assert found.min() == 0.0
    assert np.quantile(found, 0.975) == pytest.approx(0.004, rel=0.03)


def test_without_arviz_it_says_what_to_install(monkeypatch):
    def missing(name):
        raise ImportError(name)

    monkeypatch.setattr("tp_jax.report.arviz_export.import_module", missing)
    with pytest.raises(InputError, match="pip install arviz") as refused:
        to_arviz(FOUND)
    assert str(refused.value).count(".") == 1


def test_the_package_has_it():
    assert importlib.import_module("tp_jax").to_arviz is to_arviz
