"""Draws about a fit: the density's gradient, and what the draws say where all is Gaussian."""

import sys

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from tests.rigs import synthetic_campaign, synthetic_values
from tp_jax.errors import InputError
from tp_jax.estimation.baseline import prepare_campaign
from tp_jax.estimation.least_squares import fit as fit_windows
from tp_jax.identifiability.information import information
from tp_jax.identifiability.posterior import posterior
from tp_jax.identifiability.windowed_density import windowed_density

KNOWN_WELL = ("B2", "k", "A", "c1", "zero1")


@pytest.fixture(scope="module")
def setting():
    """Three seconds: of two one window is a kink, its rider just fails to stick."""
    return prepare_campaign(synthetic_campaign(), effects=())


@pytest.fixture(scope="module")
def fit(setting):
    problem = setting.problem(setting.horizons[-1])
    return fit_windows(
        problem, synthetic_values(setting), setting.unknowns(), bounds=setting.bounds,
        anchors=setting.anchors(),
    )  # fmt: skip


@pytest.fixture(scope="module")
def density(fit, setting):
    return windowed_density(fit, setting)


@pytest.fixture(scope="module")
def at(density):
    both = jax.jit(lambda z, data: jax.value_and_grad(density.of(data))(z))
    return lambda z: tuple(np.asarray(x) for x in both(jnp.asarray(z), density.data))


def test_white_coordinates_begin_at_the_fit(fit, density):
    np.testing.assert_allclose(
        density.values(np.zeros(len(density.names))), fit.values.pick(fit.unknowns), rtol=1e-12
    )


def test_it_falls_off_as_a_white_normal_does(density, at):
    """Half a unit of log density for each axis at one standard deviation."""
    top, _ = at(np.zeros(len(density.names)))
    drops = [0.5 * sum(top - at(s * e)[0] for s in (-1.0, 1.0)) for e in np.eye(len(density.names))]
    np.testing.assert_allclose(np.median(drops), 0.5, atol=0.2)


def test_gradient(density, at):
    z = np.full(len(density.names), 0.3)
    _, gradient = at(z)
    h = 0.05
    found = np.array([(at(z + h * e)[0] - at(z - h * e)[0]) / (2.0 * h) for e in np.eye(z.size)])
    # a window in which a body just fails to stick has a kink, so not all of them to all digits
    assert np.median(np.abs(found - gradient)) < 0.05


@pytest.mark.slow
def test_draws(fit, setting):
    found = posterior(fit, setting, draws=30, warmup=20, chains=2, seed=1)
    assert found.samples.shape == (2, 30, len(found.names))
    known = information(fit, setting)
    for name in KNOWN_WELL:
        i = known.names.index(name)
        x = found.of(name)
        assert abs(x.mean() - fit.values.get(name)) < 1.5 * known.sd[i], name
        assert 0.5 * known.sd[i] < x.std() < 2.0 * known.sd[i], name
    table = found.to_dict()
    assert table["chains"] == 2
    assert set(table["parameters"]["k"]) == {"mean", "sd", "ci95", "rhat", "ess"}
    low, high = table["parameters"]["Ts1"]["ci95"]
    assert 0.0 < low < high


def test_too_little_is_refused(fit, setting):
    with pytest.raises(InputError, match="two chains"):
        posterior(fit, setting, chains=1)


def test_without_blackjax(fit, setting, monkeypatch):
    monkeypatch.setitem(sys.modules, "blackjax", None)
    with pytest.raises(InputError, match=r"tp-jax\[posterior\]"):
        posterior(fit, setting)
