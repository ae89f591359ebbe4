"""What is known about the model, and the paper does not say."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.model.energies import energy
from tests.reference import BENCH, PAPER, SCALED
from tp_jax.model import presets
from tp_jax.simulation import simulate

TS = np.linspace(0.0, 1.0, 251)


@jax.jit
def motion(values: dict, y0: jax.Array) -> jax.Array:
    """(4, n) from plain numbers."""
    return jnp.stack(simulate(presets.double_pendulum(**values), TS, y0)[1:])


@jax.jit
def energies(values: dict, y: jax.Array):
    """Energy along a motion (4, n)."""
    return jax.vmap(energy, (None, 0, 0))(presets.double_pendulum(**values), jnp.asarray(TS), y.T)


REST = jnp.zeros(4)
LIVELY = jnp.array([0.2, -0.1, 3.0, -6.0])


def test_the_printed_factor_halves_the_column():
    printed = BENCH | {"reaction": 2.0}
    halved = printed | {"reaction": 1.0}
    for name in ("B1", "k", "c1", "M1"):
        halved[name] = printed[name] / 2.0
    np.testing.assert_allclose(motion(printed, LIVELY), motion(halved, LIVELY), atol=1e-12)


@settings(max_examples=20)
@given(st.floats(0.1, 10.0))
def test_the_scale_is_free(factor):
    scaled = {n: v * factor if n in SCALED else v for n, v in BENCH.items()}
    np.testing.assert_allclose(motion(scaled, REST)[:2], motion(BENCH, REST)[:2], atol=1e-8)


@settings(max_examples=25)
@given(
    st.tuples(*[st.floats(-1.0, 1.0)] * 2, *[st.floats(-15.0, 15.0)] * 2),
    st.sampled_from([1.0, 2.0]),
)
def test_energy_never_grows_undriven(y0, reaction):
    values = BENCH | {"A": 0.0, "reaction": reaction}
    total = energies(values, motion(values, jnp.array(y0))).total
    assert np.diff(total).max() <= 1e-7 * total.max() + 1e-15


def test_without_the_factor_in_the_books_energy_seems_to_rise():
    values = BENCH | {"A": 0.0, "c1": 0.0, "M1": 0.0, "reaction": 2.0}
    phi1, _, v1, v2 = np.asarray(motion(values, jnp.array([0.0, 0.0, 1.5, 0.3])))
    naive = 0.5 * (BENCH["B1"] * v1**2 + BENCH["B2"] * (v1 + v2) ** 2 + BENCH["k"] * phi1**2)
    assert np.diff(naive).max() > 1e-3 * naive.max()


@pytest.mark.parametrize("reaction", [1.0, 2.0])
def test_power_balance(reaction):
    model = presets.double_pendulum(**BENCH | {"reaction": reaction})
    rng = np.random.default_rng(0)
    for _ in range(5):
        t = jnp.asarray(rng.uniform(0.0, 3.0))
        y = jnp.asarray(rng.normal(size=4) * [0.3, 0.3, 5.0, 5.0])
        along = (jnp.ones_like(t), model.vector_field(t, y))
        e, rate = jax.jvp(lambda t, y: energy(model, t, y), (t, y), along)
        assert rate.total == pytest.approx(
            float(e.drive_power - e.bearing_loss - e.contact_loss), rel=1e-10, abs=1e-14
        )
        assert e.bearing_loss > 0.0
        assert e.contact_loss > 0.0


def test_from_rest_the_papers_rider_never_slips():
    run = simulate(presets.get("paper-5.1"), np.linspace(0.0, 10.0, 2501))
    assert np.abs(run.phi2).max() == pytest.approx(3.2e-4, rel=0.02)


def test_Ts2_has_no_influence():
    for y0 in (REST, LIVELY):  # at rest to start with, and sliding both ways
        without, with_it = motion(PAPER | {"Ts2": 0.0}, y0), motion(PAPER | {"Ts2": 7.0}, y0)
        np.testing.assert_array_equal(without, with_it)
