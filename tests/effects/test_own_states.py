"""Effects with a memory: nothing at null, a derivative there, the equation, a past."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.effects.own_states import (
    IDS,
    OMEGA,
    TS,
    amplitude,
    angles,
    bench,
    direction,
    effect,
    middle,
)
from tests.reference import BENCH
from tests.rig.dahl import smoothed
from tp_jax.effects import Effect
from tp_jax.simulation import sensitivities, simulate

every = pytest.mark.parametrize("id", IDS)
stateful = pytest.mark.parametrize("id", [id for id in IDS if effect(id).n_states])


def values(id: str, part: float, **shapes: float) -> dict[str, float]:
    """A part of the typical amplitude, and shape constants."""
    (only,) = effect(id).amplitudes
    return {only.name: part * only.typical} | middle(id) | shapes


def test_only_the_play_of_a_known_sine_needs_no_state():
    assert {id: effect(id).n_states for id in IDS} == {
        "base_compliance": 2,
        "bearing_presliding": 1,
        "column_cable": 1,
        "contact_presliding": 1,
        "drive_backlash": 0,
        "spring_hysteresis": 1,
    }


@every
def test_null_is_the_plain_model(id):
    rng = np.random.default_rng(0)
    plain, null = bench(), bench(id, values(id, 0.0))
    for _ in range(6):
        t = jnp.asarray(rng.uniform(0.0, 2.0))
        y = tuple(jnp.asarray(rng.normal(size=4) * [0.3, 0.6, 4.0, 4.0]))
        own = tuple(jnp.asarray(x) for x in 0.01 * rng.normal(size=effect(id).n_states))
        np.testing.assert_array_equal(
            null.derivative(t, y + own)[:4], plain.derivative(t, y), strict=False
        )
        np.testing.assert_array_equal(null.readings(t, y + own), plain.readings(t, y))
    # steps are bounded by the error of the own states too: the same motion, not the same steps
    np.testing.assert_allclose(angles(null), angles(plain), rtol=0.0, atol=3e-8)


@every
def test_states_stay_at_rest_in_equilibrium(id):
    model = bench(id, values(id, 1.0), A=0.0)
    n = model.n_states
    t, y = jnp.asarray(0.3), tuple(jnp.zeros(n))
    np.testing.assert_array_equal(model.derivative(t, y), np.zeros(n))


@every
def test_derivative_at_null_is_that_of_the_motion(id):
    name, shapes = amplitude(id), middle(id)
    exact = direction(id, shapes)
    (only,) = effect(id).amplitudes
    # a typical size moves the readings by more than their noise
    assert only.typical * np.sqrt(np.mean(exact**2)) > 1e-3
    errors = []
    for h in np.array([0.1, 0.01]) * only.typical:
        # below zero too, where the formula goes on although physics does not
        ends = [angles(bench(id, {name: x} | shapes), tolerance=1e-11) for x in (h, -h)]
        errors.append(np.linalg.norm((ends[0] - ends[1]) / (2 * h) - exact) / np.linalg.norm(exact))
    assert errors[1] < max(0.1 * errors[0], 2e-5)
    assert errors[1] < 2e-4


@pytest.mark.slow
def test_the_engine_finds_the_same_derivative():
    id = "base_compliance"
    model = bench(id, values(id, 0.0))
    found = sensitivities(model, TS, by=["terms.0.values.a"], tolerance=1e-8)
    assert found.reliable.all()
    both = np.stack([found.phi1[:, -1], found.phi2[:, -1]], axis=1)
    exact = direction(id, middle(id))
    assert np.linalg.norm(both - exact) < 2e-3 * np.linalg.norm(exact)


@every
@pytest.mark.parametrize("eps", [1e3, 5e4])
def test_is_the_catalogues_equation(id, eps):
    # written anew in plain numbers, and integrated by SciPy
    given = values(id, 1.5)
    numbers = BENCH | dict(omega=OMEGA, eps=eps)
    expected = smoothed(numbers, TS, id, given)
    found = angles(bench(id, given, eps=eps))
    assert np.abs(expected - angles(bench(eps=eps))).max() > 1e-3
    # a run begins in the middle of a gap, which the formula does not know
    atol = 1e-4 if id == "drive_backlash" else 2e-7
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=atol)


@every
@pytest.mark.parametrize("eps", [1e3, 5e4])
def test_runs_at_all_sizes(id, eps):
    (only,) = effect(id).amplitudes
    for part in (1.0, min(10.0, only.upper / only.typical)):
        for shapes in zip(*[(s.grid[0], s.grid[-1]) for s in effect(id).shapes], strict=True):
            named = dict(zip(middle(id), shapes, strict=True))
            model = bench(id, values(id, part, **named), eps=eps)
            assert np.isfinite(angles(model)).all()
            # let go, with the motor at rest
            still = bench(id, values(id, part, **named), eps=eps, A=0.0)
            y0 = np.zeros(still.n_states)
            y0[0] = 0.8
            assert np.isfinite(angles(still, y0=y0)).all()


@stateful
def test_past_is_what_the_rates_lead_to(id):
    model = bench(id, values(id, 1.0))
    term, n = model.terms[0], effect(id).n_states
    dense = np.linspace(0.0, 1.0, 4001)

    def motion(t, own):
        t = jnp.asarray(t)
        phi1, v1 = 0.3 * jnp.sin(14.0 * t), 4.2 * jnp.cos(14.0 * t)
        phi2, v2 = 0.2 * jnp.sin(23.0 * t) ** 2, 4.6 * jnp.sin(46.0 * t)
        return model.motion(t, (phi1, phi2, v1, v2, *own))

    @jax.jit
    def rates(t, z):
        m = motion(t, tuple(z))
        m.z = tuple(z)
        return jnp.stack(term.rates(m))

    expected = solve_ivp(
        lambda t, z: np.asarray(rates(t, z)),
        (0.0, 1.0),
        np.zeros(n),
        t_eval=dense[::200],
        rtol=1e-6,
        atol=1e-8,
        max_step=5e-3,
    ).y
    found = np.stack(term.past(motion(dense, (0.0 * dense,) * n)))
    assert found.shape == (n, dense.size)
    error = np.abs(found[:, ::200] - expected).max(axis=1)
    assert (error < 0.01 * np.abs(expected).max(axis=1)).all()


@stateful
def test_a_window_that_begins_with_its_past_goes_on_like_the_run(id):
    model = bench(id, values(id, 1.0))
    n = effect(id).n_states
    # as many samples as everywhere, so that one program does it all
    ts, first = np.linspace(0.0, 1.2, TS.size), 400
    run = np.stack(simulate(model, ts)[1:])
    columns = tuple(jnp.asarray(x) for x in run)
    past = model.terms[0].past(model.motion(jnp.asarray(ts), (*columns, *(0.0 * ts,) * n)))
    later, errors = np.linspace(ts[first], ts[-1], TS.size), []
    for own in (np.stack(past)[:, first], np.zeros(n)):
        window = angles(model, later, np.concatenate([run[:, first], own]))
        errors.append(np.abs(window[::5] - run[:2, first:].T).max())
    assert errors[0] < 0.1 * errors[1]
    assert errors[1] > 3e-5


@stateful
def test_past_does_not_depend_on_the_amplitude(id):
    t = jnp.linspace(0.0, 1.0, 101)
    y = (0.3 * jnp.sin(14.0 * t), 0.2 * jnp.sin(23.0 * t), jnp.cos(t), jnp.sin(t))
    pasts = []
    for part in (0.0, 1.0):
        model = bench(id, values(id, part))
        m = model.motion(t, (*y, *(0.0 * t,) * effect(id).n_states))
        pasts.append(np.stack(model.terms[0].past(m)))
    np.testing.assert_array_equal(*pasts)
    np.testing.assert_array_equal(pasts[0][:, 0], 0.0)


def test_an_effect_that_says_nothing_of_its_past_has_none():
    class Silent(Effect):
        n_states = 2

    m = bench().motion(jnp.linspace(0.0, 1.0, 5), tuple(jnp.zeros((4, 5))))
    np.testing.assert_array_equal(Silent().past(m), np.zeros((2, 5)))


def test_a_base_is_seen_in_four_samples_of_a_period():
    base = effect("base_compliance")
    assert base.resolved(13.0, 0.004)
    assert not base.resolved(3.0, 0.09)
