"""Method and step size in a user's own diffrax script."""

import diffrax
import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
import pytest
from scipy.linalg import expm

import tp_jax as tp
from tp_jax.model import Bearing, Contact, DoubleTorsionPendulum, LinearSpring, SineDrive
from tp_jax.simulation.control import Control
from tp_jax.simulation.parts import take_apart
from tp_jax.simulation.runs import integrate

BENCH = tp.presets.values("bench")
SPAN = 1.0


def bench(**changed):
    return tp.presets.double_pendulum(**BENCH | changed)


def solve(model, tolerance=1e-8, y0=(0.0, 0.0, 0.0, 0.0), span=SPAN, **rest):
    """As a user would write it."""
    options = dict(adjoint=diffrax.ForwardMode(), max_steps=20_000) | rest
    return diffrax.diffeqsolve(
        diffrax.ODETerm(model.vector_field),
        tp.Rodas4(),
        0.0,
        span,
        1e-4,
        jnp.array(y0),
        stepsize_controller=tp.ReversalController(model, tolerance),
        **options,
    )


def linear_pendulum():
    """Both bodies coupled by viscous friction alone, the motor at rest."""
    model = DoubleTorsionPendulum(
        drive=SineDrive(A=0.0, omega=1.0),
        spring=LinearSpring(40.0),
        B1=1.0,
        B2=0.5,
        bearing=Bearing(c1=0.5, M1=0.0, eps=1.0),
        contact=Contact(Tv=0.7, Ts1=0.0, Tst=0.0, T0=1.0, eps=1.0),
    )
    acceleration1 = np.array([-40.0, 0.0, -0.5, 0.7])
    acceleration2 = np.array([0.0, 0.0, 0.0, -0.7 / 0.5]) - acceleration1
    return model, np.array([[0, 0, 1, 0], [0, 0, 0, 1], acceleration1, acceleration2])


def test_constant_steps_converge_at_order_four():
    model, matrix = linear_pendulum()
    y0 = np.array([0.3, 0.0, 1.0, -2.0])
    expected = expm(matrix) @ y0
    np.testing.assert_allclose(model.vector_field(jnp.zeros(()), jnp.asarray(y0)), matrix @ y0)

    @jax.jit
    def end(h):
        return diffrax.diffeqsolve(
            diffrax.ODETerm(model.vector_field), tp.Rodas4(), 0.0, 1.0, h, jnp.asarray(y0)
        ).ys[0]

    errors = [np.abs(end(1.0 / n) - expected).max() for n in (20, 40, 80)]
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 4.0, atol=0.3)


@pytest.mark.parametrize(("eps", "tolerance"), [(1e3, 1e-6), (5e4, 1e-8)])
def test_takes_the_steps_of_the_batch_engine(eps, tolerance):
    # samples at both ends only: the engine's steps pass two samples at the most
    model, y0 = bench(eps=eps), np.array([0.3, 0.0, 0.0, 0.0])
    parts = take_apart(model)
    p = tuple(jnp.reshape(x, 1) for x in parts.values)
    ran = integrate(
        parts.field,
        p,
        jnp.asarray(y0)[:, None],
        np.array([0.0, SPAN]),
        (p[parts.eps[0]], p[parts.eps[1]]),
        Control(angle=tolerance),
        width=1,
    )
    first = 1e-2 * SPAN
    found = diffrax.diffeqsolve(
        diffrax.ODETerm(model.vector_field),
        tp.Rodas4(),
        0.0,
        SPAN,
        first,
        jnp.asarray(y0),
        stepsize_controller=tp.ReversalController(model, tolerance),
        max_steps=20_000,
    )
    assert int(found.stats["num_steps"]) == int(ran.steps[0]) > 100
    np.testing.assert_allclose(found.ys[0], ran.y[0, -1], rtol=0, atol=1e-9)


def test_simulate_solves_once_by_diffrax(monkeypatch):
    calls = []
    whole = diffrax.diffeqsolve
    monkeypatch.setattr(
        diffrax, "diffeqsolve", lambda *a, **k: calls.append(a[1]) or whole(*a, **k)
    )
    ts = np.linspace(0.0, 0.1, 7)  # a length that nothing else has compiled
    motion = tp.simulate(bench(), ts)
    assert len(calls) == 1
    assert isinstance(calls[0], tp.Rodas4)
    many = solve(bench(), span=0.1, saveat=diffrax.SaveAt(ts=ts))
    np.testing.assert_allclose(motion.phi1, many.ys[:, 0], rtol=0, atol=1e-8)


def test_dense_output_is_the_motion_between_steps():
    model, ts = bench(), np.linspace(0.0, SPAN, 301)
    found = solve(model, saveat=diffrax.SaveAt(dense=True))
    inside = jax.vmap(found.evaluate)(ts)
    fine = tp.simulate(model, ts, tolerance=1e-11)
    for k, name in enumerate(("phi1", "phi2", "omega1", "omega2")):
        expected = np.asarray(getattr(fine, name))
        error = np.abs(inside[:, k] - expected).max() / np.abs(expected).max()
        assert error < (1e-5 if k < 2 else 1e-2), name
    np.testing.assert_allclose(found.evaluate(0.2, 0.5), found.evaluate(0.5) - found.evaluate(0.2))


def test_steps_are_saved():
    found = solve(bench(), saveat=diffrax.SaveAt(steps=True), max_steps=4096)
    ts = np.asarray(found.ts)[np.isfinite(found.ts)]
    assert ts.size == int(found.stats["num_accepted_steps"])
    assert (np.diff(ts) > 0.0).all()


def test_an_event_at_the_riders_first_slip():
    # it rides along, held by friction, until the column turns fast enough
    model = bench()
    slip = 0.02

    def slipped(t, y, args, **rest):
        return jnp.abs(y[3]) - slip

    root = optx.Newton(1e-10, 1e-10)
    found = solve(model, event=diffrax.Event(slipped, root), adjoint=diffrax.DirectAdjoint())
    assert found.event_mask
    ts = np.linspace(0.0, SPAN, 40_001)
    v2 = np.asarray(tp.simulate(model, ts, tolerance=1e-10).omega2)
    first = np.argmax(np.abs(v2) > slip)
    expected = np.interp(slip, np.abs(v2[first - 1 : first + 1]), ts[first - 1 : first + 1])
    assert float(found.ts[0]) == pytest.approx(expected, abs=2e-5)


WEIGHTS = jnp.array([1.0, -2.0, 0.02, 0.01])


def loss(k, adjoint, **rest):
    return jnp.sum(WEIGHTS * solve(bench(k=k), adjoint=adjoint, **rest).ys[-1])


def test_a_reverse_gradient_through_sticking():
    # a run that sticks and slips; a step's size does not depend on k, so the derivative is that of
    # the steps, and differences of a converged run have it
    k = BENCH["k"]
    gradient = jax.jit(jax.grad(lambda k: loss(k, diffrax.RecursiveCheckpointAdjoint())))(k)
    forward = jax.jit(jax.jacfwd(lambda k: loss(k, diffrax.ForwardMode())))(k)
    fine = jax.jit(lambda k: loss(k, diffrax.ForwardMode(), tolerance=1e-12, max_steps=200_000))
    h = 1e-5 * k
    expected = (fine(k + h) - fine(k - h)) / (2.0 * h)
    assert float(gradient) == pytest.approx(float(forward), rel=1e-6)
    assert float(gradient) == pytest.approx(float(expected), rel=2e-3)


@pytest.mark.parametrize("mode", ["forward", "backward"])
def test_no_nan_at_rest_or_at_a_reversal(mode):
    # at rest every velocity is zero, and so is the drive at t = 0
    def end(numbers, y0):
        model = bench(k=numbers[0], Ts1=numbers[1])
        adjoint = diffrax.ForwardMode() if mode == "forward" else diffrax.DirectAdjoint()
        saveat = diffrax.SaveAt(ts=jnp.linspace(0.0, 0.005, 5))
        # sixteen steps are one loop to diffrax: more are loops in loops, each compiled backward
        options = dict(tolerance=1e-4, adjoint=adjoint, max_steps=16, saveat=saveat)
        return solve(model, y0=y0, span=0.005, **options).ys  # not a number, were they too few

    derive = jax.jacfwd if mode == "forward" else jax.jacrev
    starts = jnp.array([[0.0, 0.0, 0.0, 0.0], [0.1, 0.0, 0.0, 0.0], [0.0, 0.0, 0.5, 0.0]])
    numbers = jnp.array([BENCH["k"], BENCH["Ts1"]])
    whole = eqx.filter_jit(jax.vmap(derive(end, (0, 1)), (None, 0)))
    for each in whole(numbers, starts):
        assert np.isfinite(each).all()


def test_time_may_run_backwards():
    # without friction what was is had back
    model, _ = linear_pendulum()
    model = eqx.tree_at(lambda m: (m.bearing.c1, m.contact.Tv), model, (0.0, 0.0))
    there = solve(model, y0=(0.3, 0.0, 1.0, -2.0)).ys[-1]
    back = diffrax.diffeqsolve(
        diffrax.ODETerm(model.vector_field),
        tp.Rodas4(),
        1.0,
        0.0,
        -1e-4,
        there,
        stepsize_controller=tp.ReversalController(model, 1e-10),
        max_steps=20_000,
    ).ys[-1]
    np.testing.assert_allclose(back, [0.3, 0.0, 1.0, -2.0], atol=1e-5)
