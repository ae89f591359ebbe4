"""Nelder-Mead takes SciPy's steps, alone, under vmap and from many simplices at once."""

import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
import pytest
import scipy.optimize
from jax.custom_batching import custom_vmap
from scipy.optimize import Bounds

from tp_jax.estimation.nelder_mead import NelderMead, minimise_many
from tp_jax.estimation.simplex import Box, initial_simplex


@jax.jit
def rosenbrock(x):
    return jnp.sum(100.0 * (x[1:] - x[:-1] ** 2) ** 2 + (1.0 - x[:-1]) ** 2)


@jax.jit
def powell(x):
    """Powell's singular function of four variables (1962)."""
    a, b, c, d = x
    return (a + 10 * b) ** 2 + 5 * (c - d) ** 2 + (b - 2 * c) ** 4 + 10 * (a - d) ** 4


@jax.jit
def stairs(x):
    """Steps of a bowl: values tie all the time, and no point between is special."""
    return jnp.floor(4.0 * jnp.sum((x - 0.3) ** 2))


@jax.jit
def crater(x):
    """A ring: from across it, contractions fail and the simplex shrinks."""
    return jnp.abs(jnp.sum(x**2) - 1.0) + 1e-3 * x[0]


@jax.jit
def cliff(x):
    """No value on one side."""
    return jnp.where(x[0] < -0.5, jnp.inf, jnp.sum((x - jnp.arange(x.size)) ** 2))


CASES = {
    "rosenbrock": (rosenbrock, [-1.2, 1.0]),
    "rosenbrock in three": (rosenbrock, [-1.2, 1.0, 0.7]),
    "powell": (powell, [3.0, -1.0, 0.0, 1.0]),
    "stairs": (stairs, [2.0, -1.0, 3.0]),
    "crater": (crater, [0.01, 0.0]),
    "cliff": (cliff, [-0.49, 3.0]),
}
SHRINKING = np.array([[0.0, 0.0], [2.0, 0.1], [0.1, 2.0]])


@pytest.fixture
def stable(monkeypatch):
    """SciPy's order of vertices with equal values, whatever the processor NumPy sorts on."""
    order = np.argsort
    monkeypatch.setattr(np, "argsort", lambda a, *p, **k: order(a, *p, **(k | {"stable": True})))


def scipy_simplex(f, start, iterations, **options):
    """SciPy's vertices and values after so many iterations; a vertex's own value, not a twin's."""
    found = scipy.optimize.minimize(
        lambda x: float(f(jnp.asarray(x))),
        start,
        method="Nelder-Mead",
        options={"maxiter": iterations + 1, "maxfev": 10**9, "xatol": 0.0, "fatol": 0.0, **options},
    )
    return found.final_simplex


def simplices(f, start, iterations, **options):
    """Vertices and values after each iteration of `NelderMead`, stepped by hand."""
    solver = NelderMead(adaptive=options.pop("adaptive", False))
    fn = lambda y, args: (jnp.asarray(f(y), float), None)  # noqa: E731
    y = jnp.asarray(start, float)
    struct = jax.ShapeDtypeStruct((), y.dtype)
    state = solver.init(fn, y, None, options, struct, None, frozenset())
    step = jax.jit(lambda y, s: solver.step(fn, y, None, options, s, frozenset())[:2])
    seen = []
    while len(seen) <= iterations:
        y, state = step(y, state)
        s = state.simplex
        if s.between:
            assert int(s.iterations) == len(seen)
            seen.append((np.asarray(s.vertices), np.asarray(s.values)))
    return seen


@pytest.mark.usefixtures("stable")
@pytest.mark.parametrize("name", CASES)
def test_each_iteration_is_scipys(name):
    f, start = CASES[name]
    mine = simplices(f, start, 60)
    for k in (*range(20), 35, 60):
        vertices, values = scipy_simplex(f, start, k)
        np.testing.assert_allclose(mine[k][0], vertices, rtol=1e-9, atol=1e-12, err_msg=str(k))
        np.testing.assert_allclose(mine[k][1], values, rtol=1e-8, atol=1e-12, err_msg=str(k))


@pytest.mark.usefixtures("stable")
def test_a_shrink_is_scipys():
    # from here the first contraction is worse than the worst vertex
    f = jax.jit(lambda x: jnp.sum(jnp.sin(3.0 * x) ** 2) - 0.1 * x[0])
    mine = simplices(f, SHRINKING[0], 12, simplex=jnp.asarray(SHRINKING))
    halved = 0
    for k in range(13):
        vertices, values = scipy_simplex(f, SHRINKING[0], k, initial_simplex=SHRINKING)
        np.testing.assert_allclose(mine[k][0], vertices, rtol=1e-12, atol=1e-14)
        np.testing.assert_allclose(mine[k][1], values, rtol=1e-12, atol=1e-14)
        if k:
            edges = [np.abs(np.linalg.det(np.diff(v, axis=0))) for v in (mine[k - 1][0], vertices)]
            halved += bool(np.isclose(edges[1] / edges[0], 0.25))
    assert halved >= 1, "no shrink happened: the case tests nothing"


@pytest.mark.usefixtures("stable")
@pytest.mark.parametrize("name", ["rosenbrock in three", "powell"])
def test_adaptive_coefficients_are_scipys(name):
    f, start = CASES[name]
    mine = simplices(f, start, 40, adaptive=True)
    for k in (0, 1, 5, 12, 25, 40):
        vertices, _ = scipy_simplex(f, start, k, adaptive=True)
        np.testing.assert_allclose(mine[k][0], vertices, rtol=1e-9, atol=1e-12)


@pytest.mark.usefixtures("stable")
@pytest.mark.parametrize("start", [[-1.0, 0.5], [0.5, 0.5], [0.499, 2.0]])
def test_bounds_are_scipys(start):
    low, high = np.array([-1.5, -0.5]), np.array([0.5, 2.0])
    found = scipy.optimize.minimize(
        lambda x: float(rosenbrock(jnp.asarray(x))),
        start,
        method="Nelder-Mead",
        bounds=Bounds(low, high),
        options={"xatol": 1e-8, "fatol": 1e-8},
    )
    mine = optx.minimise(
        lambda y, args: rosenbrock(y),
        NelderMead(atol=1e-8),
        jnp.asarray(start),
        options={"lower": jnp.asarray(low), "upper": jnp.asarray(high)},
        max_steps=2000,
    )
    np.testing.assert_allclose(mine.value, found.x, rtol=1e-10)
    assert int(mine.stats["evaluations"]) == found.nfev
    assert int(mine.stats["iterations"]) == found.nit - 1  # SciPy counts the first simplex as one


@pytest.mark.usefixtures("stable")
@pytest.mark.parametrize("name", ["rosenbrock", "rosenbrock in three", "powell", "cliff"])
def test_ends_where_and_when_scipy_does(name):
    f, start = CASES[name]
    found = scipy.optimize.minimize(lambda x: float(f(jnp.asarray(x))), start, method="Nelder-Mead")
    mine = optx.minimise(lambda y, args: f(y), NelderMead(), jnp.asarray(start), max_steps=2000)
    assert found.success
    assert int(mine.stats["evaluations"]) == found.nfev
    np.testing.assert_allclose(mine.value, found.x, rtol=1e-9, atol=1e-12)


def test_quadratics_from_many_starts():
    # where optimistix's own reports success and has found one minimum in ten
    H = jnp.asarray([[4.0, 1.0, 0.5], [1.0, 3.0, -1.0], [0.5, -1.0, 2.0]])
    f = lambda y, args: 0.5 * (y - 1.0) @ H @ (y - 1.0)  # noqa: E731
    starts = jnp.asarray(np.random.default_rng(0).normal(size=(64, 3)) * 3.0)
    one = lambda y: optx.minimise(f, NelderMead(), y, max_steps=2000, throw=False)  # noqa: E731
    found = jax.vmap(lambda y: one(y).value)(starts)
    np.testing.assert_allclose(found, 1.0, atol=2e-3)


def test_lanes_are_as_alone():
    starts = np.random.default_rng(1).normal(size=(7, 4))
    starts[3] = [1e3, -1e3, 1e3, 1e3]  # one that takes long
    solve = lambda y: optx.minimise(  # noqa: E731
        lambda y, args: powell(y), NelderMead(), y, max_steps=3000, throw=False
    )
    many = jax.vmap(lambda y: (solve(y).value, solve(y).stats["evaluations"]))(jnp.asarray(starts))
    for start, x, evaluations in zip(starts, *many, strict=True):
        alone = solve(jnp.asarray(start))
        np.testing.assert_allclose(x, alone.value, rtol=1e-8, atol=1e-10)
        assert int(evaluations) == int(alone.stats["evaluations"])


def test_a_tree_is_as_its_leaves_in_a_row():
    f = lambda y, args: powell(jnp.concatenate([y["a"].ravel(), y["b"][None]]))  # noqa: E731
    tree = {"a": jnp.array([[3.0], [-1.0], [0.0]]), "b": jnp.array(1.0)}
    found = optx.minimise(f, NelderMead(), tree, max_steps=2000).value
    flat = optx.minimise(
        lambda y, a: powell(y), NelderMead(), jnp.array([3.0, -1, 0, 1]), max_steps=2000
    )
    np.testing.assert_array_equal(found["a"].ravel(), flat.value[:3])
    np.testing.assert_array_equal(found["b"], flat.value[3])


def test_fminsearch_stops_at_rounding():
    f = lambda y, args: 1e9 + jnp.sum((y - 1e6) ** 2)  # noqa: E731
    start = jnp.array([1.01e6, 0.99e6])
    solver = NelderMead(atol=0.0, rule="fminsearch")
    done = optx.minimise(f, solver, start, max_steps=2000, throw=False)
    assert done.result == optx.RESULTS.successful
    np.testing.assert_allclose(done.value, 1e6, rtol=1e-8)
    endless = optx.minimise(f, NelderMead(atol=-1.0), start, max_steps=500, throw=False)
    assert endless.result == optx.RESULTS.nonlinear_max_steps_reached


def test_first_simplex():
    made = initial_simplex(jnp.array([2.0, 0.0, -4.0]))
    expected = [[2.0, 0.0, -4.0], [2.1, 0.0, -4.0], [2.0, 0.00025, -4.0], [2.0, 0.0, -4.2]]
    np.testing.assert_allclose(made, expected, rtol=1e-15)
    box = Box(jnp.array([0.0, 0.0]), jnp.array([1.0, 1.0]))
    np.testing.assert_allclose(
        initial_simplex(jnp.array([1.0, 0.5]), box), [[1.0, 0.5], [0.95, 0.5], [1.0, 0.525]]
    )


def test_a_wrong_simplex_is_told():
    with pytest.raises(ValueError, match="must hold 3 vertices"):
        optx.minimise(
            lambda y, a: jnp.sum(y**2), NelderMead(), jnp.zeros(2), options={"simplex": jnp.eye(2)}
        )


# Many at once --------------------------------------------------------------------------------


def in_lanes(f, seen=None):
    """`f` for `minimise_many`, which asks it for many lanes at once."""

    @custom_vmap
    def value(x, active):
        return jnp.asarray(f(x), float)

    @value.def_vmap
    def _(size, mapped, x, active):
        if seen is not None:
            jax.debug.callback(lambda n: seen.append(int(n)), active)
        return jax.vmap(lambda x: jnp.asarray(f(x), float))(x), True

    return lambda x, lane, active: value(x, active)


@pytest.mark.parametrize("name", ["rosenbrock in three", "powell", "crater", "stairs"])
def test_many_are_as_alone(name):
    f, start = CASES[name]
    starts = np.asarray(start) + 0.3 * np.random.default_rng(2).normal(size=(5, len(start)))
    starts[2] *= 30.0
    most = 200 * len(start)
    found = minimise_many(
        in_lanes(f), NelderMead(), np.asarray(initial_simplex(starts)), max_steps=most
    )
    for lane, x in enumerate(starts):
        alone = optx.minimise(
            lambda y, args: f(y), NelderMead(), jnp.asarray(x), max_steps=most + 50, throw=False
        )
        if not found.converged[lane]:
            continue
        np.testing.assert_allclose(found.x[lane], alone.value, rtol=1e-8, atol=1e-10)
        assert found.evaluations[lane] == int(alone.stats["evaluations"])
        assert found.iterations[lane] == int(alone.stats["iterations"])
    assert found.converged.sum() >= 3


def test_lanes_that_have_ended_are_not_counted():
    starts = np.array([[1.0, 1.0 + 1e-9], [-1.2, 1.0], [1.0 + 1e-9, 1.0], [-3.0, 4.0]])
    simplices = 1e-3 * (np.asarray(initial_simplex(starts)) - starts[:, None]) + starts[:, None]
    simplices[[1, 3]] = np.asarray(initial_simplex(starts[[1, 3]]))
    seen: list[int] = []
    found = minimise_many(in_lanes(rosenbrock, seen), NelderMead(), simplices, max_steps=400)
    jax.effects_barrier()
    assert found.converged.all()
    assert seen[0] == 4 * 3  # all vertices of the first simplices at once
    asked = seen[1:]
    assert asked[0] == 2  # two simplices were small enough from the beginning
    assert asked == sorted(asked, reverse=True)
    assert asked[-1] == 1


def test_many_end_at_their_limits():
    starts = np.array([[-1.2, 1.0], [1.0, 1.0 + 1e-9]])
    solver = NelderMead(max_iterations=10)
    lanes = []
    found = minimise_many(
        in_lanes(rosenbrock), solver, np.asarray(initial_simplex(starts)), callback=lanes.append
    )
    assert found.iterations.max() == 10
    assert not found.converged[0]
    vertices, _ = scipy_simplex(rosenbrock, [-1.2, 1.0], 10)
    np.testing.assert_allclose(lanes[-1].vertices[0], vertices, rtol=1e-10)
    few = minimise_many(
        in_lanes(rosenbrock), NelderMead(), np.asarray(initial_simplex(starts)), max_steps=20
    )
    assert few.evaluations[0] < 20 + 8


def test_many_live_with_points_without_value():
    starts = np.array([[-0.49, 3.0], [2.0, 2.0]])
    found = minimise_many(in_lanes(cliff), NelderMead(), np.asarray(initial_simplex(starts)))
    np.testing.assert_allclose(found.x, [[0.0, 1.0]] * 2, atol=1e-3)
