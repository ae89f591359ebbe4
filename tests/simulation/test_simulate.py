"""One run against an independent integration, a closed form, and its own derivatives."""

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from tests.reference import BENCH, PAPER, reference
from tp_jax.effects import Applied, catalogue
from tp_jax.model import Bearing, LinearSpring, SineDrive, SingleTorsionPendulum, presets
from tp_jax.simulation import simulate

TEN = np.linspace(0.0, 10.0, 2501)


@pytest.mark.parametrize(
    ("name", "p", "ts", "within"),
    [("paper-5.1", PAPER, TEN, 1e-6), ("bench", BENCH, TEN[:501], 1e-5)],
)
def test_agrees_with_an_independent_integration(name, p, ts, within):
    run = simulate(presets.get(name), ts)
    expected = reference(p, ts)
    np.testing.assert_array_equal(run.t, ts)
    np.testing.assert_allclose(np.stack(run[1:3], axis=1), expected[:, :2], rtol=0.0, atol=within)
    np.testing.assert_allclose(np.stack(run[3:], axis=1), expected[:, 2:], rtol=0, atol=50 * within)
    if name == "bench":  # it stuck and slid, and both bodies turned round
        v1, v2 = expected[:, 2:].T
        assert (v1[1:] * v1[:-1] < 0.0).sum() > 4
        assert (np.abs(v2) < 1e-3).sum() > 20
        assert np.abs(v2).max() > 2.0


# Derivatives: a stretch in which the column turns round once and the rider slides, turns round
# twice and sticks.
TS = np.linspace(0.0, 0.2, 11)
NAMES = ("k", "M1", "Ts1", "B2", "c1", "T0", "A")
NOW = np.array([BENCH[n] for n in NAMES])
Y0 = np.array([0.1, 0.0, 8.0, -12.0])


@jax.jit
def angles(x, y0):
    """(2, n) from parameters and initial state."""
    values = BENCH | {n: x[i] for i, n in enumerate(NAMES)}
    return jnp.stack(simulate(presets.double_pendulum(**values), TS, y0)[1:3])


def expected_angles(x, y0):
    values = BENCH | dict(zip(NAMES, x, strict=True))
    return reference(values, TS, y0, rtol=1e-12, atol=1e-13)[:, :2].T


@pytest.fixture(scope="module")
def jacobian():
    """Derivatives (2, n, parameters) and (2, n, 4), by forward differentiation (jvp, mapped)."""
    return jax.jit(jax.jacfwd(angles, (0, 1)))(NOW, Y0)


def central_differences(f, x, h):
    return np.stack([(f(x + e) - f(x - e)) / (2.0 * e.sum()) for e in np.diag(h)], axis=-1)


def test_derivatives_are_those_of_the_motion(jacobian):
    by_parameter = central_differences(lambda x: expected_angles(x, Y0), NOW, 1e-6 * NOW)
    by_state = central_differences(lambda y0: expected_angles(NOW, y0), Y0, np.full(4, 1e-7))
    for found, expected in zip(jacobian, (by_parameter, by_state), strict=True):
        size = np.abs(expected).max(axis=(0, 1))
        np.testing.assert_allclose(found / size, expected / size, rtol=0.0, atol=1e-3)


def test_backward_mode_is_forward_mode_transposed():
    # of one linearisation: a program of its own rounds, and so steps, in a way of its own
    weight = np.random.default_rng(0).normal(size=(2, TS.size))
    _, along = jax.jit(lambda x: jax.linearize(lambda x: angles(x, Y0), x))(NOW)
    forward = jax.vmap(along)(jnp.eye(NOW.size))
    (backward,) = jax.linear_transpose(along, NOW)(weight)
    np.testing.assert_allclose(backward, np.einsum("cn,pcn->p", weight, forward), rtol=1e-9)


def test_a_gradient_is_that_of_the_jacobian(jacobian):
    weight = np.random.default_rng(0).normal(size=(2, TS.size))
    gradient = jax.jit(jax.grad(lambda x: jnp.sum(weight * angles(x, Y0))))(NOW)
    terms = weight[..., None] * jacobian[0]
    size = np.abs(terms).sum(axis=(0, 1))
    np.testing.assert_allclose(gradient / size, terms.sum(axis=(0, 1)) / size, atol=1e-5, rtol=0)


def test_a_batch_is_its_members():
    batch = NOW * np.linspace(0.9, 1.1, 3)[:, None]
    together = jax.vmap(angles, (0, None))(batch, Y0)
    np.testing.assert_allclose(together[1], expected_angles(NOW, Y0), rtol=0.0, atol=1e-6)
    for one, x in zip(together, batch, strict=True):
        np.testing.assert_allclose(one, angles(x, Y0), rtol=0.0, atol=1e-10)


# The column alone without dry friction is a damped, driven oscillator.
OSCILLATOR = np.array([1.2e-3, 0.45, 2.2e-3, 0.18, 0.3, 2.0])  # B1, k, c1, A, phi1, v1


def oscillator(x, ts, omega=7.0):
    """Closed form of the angle, for complex numbers too."""
    B1, k, c1, A, phi, v = x
    size = (k - B1 * omega**2) ** 2 + (c1 * omega) ** 2
    s, c = k * A * (k - B1 * omega**2) / size, -k * A * c1 * omega / size
    decay = c1 / (2.0 * B1)
    ring = np.sqrt(k / B1 - decay**2)
    C = phi - c
    S = (v - s * omega + decay * C) / ring
    own = np.exp(-decay * ts) * (C * np.cos(ring * ts) + S * np.sin(ring * ts))
    return s * np.sin(omega * ts) + c * np.cos(omega * ts) + own


def single(x, ts, omega=7.0):
    B1, k, c1, A, phi, v = x
    model = SingleTorsionPendulum(
        drive=SineDrive(A=A, omega=omega),
        spring=LinearSpring(k),
        bearing=Bearing(c1, 0.0, 1e3),
        B1=B1,
    )
    return simulate(model, ts, jnp.stack([phi, 0.0, v, 0.0]), tolerance=1e-10)


def test_single_pendulum_is_a_damped_oscillator():
    ts = np.linspace(0.0, 1.0, 11)

    @jax.jit
    def differentiated(x):
        def both(x):
            run = single(x, ts)
            return run.phi1, run

        return jax.jacfwd(both, has_aux=True)(x)

    found, run = differentiated(OSCILLATOR)
    np.testing.assert_allclose(run.phi1, oscillator(OSCILLATOR, ts), rtol=0.0, atol=1e-7)
    np.testing.assert_array_equal(run.phi2, 0.0)
    np.testing.assert_array_equal(run.omega2, 0.0)
    steps = 1e-30j * np.eye(OSCILLATOR.size)  # the complex step: derivatives to all digits
    expected = np.stack([oscillator(OSCILLATOR + e, ts).imag / 1e-30 for e in steps], axis=-1)
    size = np.abs(expected).max(axis=0)
    np.testing.assert_allclose(found / size, expected / size, rtol=0.0, atol=1e-6)


def test_single_pendulum_with_dry_friction():
    # what is left of the double one with a rider without inertia to speak of
    model = SingleTorsionPendulum(
        drive=SineDrive(A=0.18, omega=13.09),
        spring=LinearSpring(0.45),
        bearing=Bearing(2.2e-3, 5e-3, 5e4),
        B1=1.2e-3,
    )
    ts = np.linspace(0.0, 1.0, 251)
    expected = reference(BENCH | dict(B2=1e-12, Tv=0.0, Ts1=0.0, Tst=0.0), ts)
    np.testing.assert_allclose(simulate(model, ts).phi1, expected[:, 0], rtol=0.0, atol=1e-6)


@pytest.mark.unchecked
@pytest.mark.parametrize("ts", [[0.0], 1.0, [[0.0, 1.0], [2.0, 3.0]]])
def test_times_must_be_a_row(ts):
    with pytest.raises(ValueError, match="Argument `ts` must"):
        simulate(presets.get("bench"), ts)


@pytest.mark.parametrize("ts", [[1.0, 0.0], [0.0, 1.0, 1.0], [0.0, np.nan]])
def test_times_must_increase(ts):
    with pytest.raises(ValueError, match="Argument `ts` must increase"):
        simulate(presets.get("bench"), ts)


def test_another_solver_of_diffrax_and_its_derivative():
    """Implicit, so that it solves its equations by what a loop in one piece cannot call."""
    ts, bench = np.arange(26) / 250.0, presets.values("bench")

    def swung(k, solver=None):
        model = presets.double_pendulum(**bench | {"k": k})
        return jnp.sum(simulate(model, ts, tolerance=1e-7, solver=solver).phi1 ** 2)

    own, by = jax.value_and_grad(swung)(jnp.asarray(0.45))
    other, by_other = jax.jit(jax.value_and_grad(lambda k: swung(k, diffrax.Kvaerno5())))(0.45)
    assert float(other) == pytest.approx(float(own), rel=1e-4)
    assert float(by_other) == pytest.approx(float(by), rel=1e-3)


def test_many_pendulums_are_a_sweep():
    model = presets.double_pendulum(**BENCH | {"k": np.ones(3)})
    with pytest.raises(ValueError, match=r"must be one pendulum, .*; use `sweep`"):
        simulate(model, TS)


def test_what_takes_too_many_steps_ends_early():
    run = simulate(presets.get("bench"), TS, Y0, max_steps=64)
    there = np.isfinite(run.phi1).sum()
    assert 1 <= there < TS.size
    np.testing.assert_array_equal(run.phi1[there:], np.inf)
    expected = reference(BENCH, TS[:there], Y0) if there > 1 else np.array([Y0])
    np.testing.assert_allclose(run.phi2[:there], expected[:, 1], rtol=0.0, atol=1e-6)


@pytest.mark.unchecked
@pytest.mark.parametrize("y0", [0.0, [0.0, 0.0], np.zeros((4, 1)), np.zeros(5)])
def test_a_start_must_fit_the_model(y0):
    with pytest.raises(ValueError, match="Argument `y0` must have shape"):
        simulate(presets.get("bench"), TS, y0)


@pytest.mark.parametrize("solver", [None, diffrax.Kvaerno5()])
def test_derivatives_by_times(solver):
    ts, y0, step = np.linspace(0.3, 1.0, 8), np.array([0.1, 0.05, 1.0, 2.0]), 1e-5

    @jax.jit
    def last(ts):
        motion = simulate(presets.get("bench"), ts, y0, tolerance=1e-9, solver=solver)
        return motion.phi2[-1]

    found = jax.grad(last)(jnp.asarray(ts))
    moved = [(last(ts + d) - last(ts - d)) / (2.0 * step) for d in step * np.eye(8)]
    np.testing.assert_allclose(found, moved, rtol=1e-3, atol=1e-6)
    assert abs(found[0]) > 0.01
    assert abs(found[-1]) > 0.01


def test_derivatives_by_times_of_effects_that_remember_are_refused():
    remembers = next(e for e in catalogue().values() if e.n_states == 1)
    sizes = {x.name: 0.0 for x in remembers.amplitudes} | {
        x.name: x.grid[0] for x in remembers.shapes
    }
    terms = (Applied(remembers, sizes),)
    model = presets.double_pendulum(**presets.values("bench"), terms=terms)
    with pytest.raises(ValueError, match="states of their own"):
        jax.grad(lambda ts: simulate(model, ts).phi1[-1])(jnp.linspace(0.0, 0.1, 3))
