"""Many short runs at once, with tangents: the engine under all estimation.

Every run (a window of a recording, at some parameters) is a *lane*: the last axis of every array.
Each lane has its own time, step and sample; none waits for another at a sample. Steps land on the
samples. The method is ROS34PW2 (`tp_jax.simulation.tableau`), with the closed-form 2x2 solve.

Tangents are integrated beside the state by the same method, with the same matrix: it is a
W-method, so that the second derivatives an exact differentiation would need are not. All
directions share the Jacobian and the partial derivatives of a stage, so that a tangent costs a
few multiplications.

Three things bound a step: the embedded error of the state, that of the tangents (loosely), and
the *linearisation error of the friction*, |S(v1) - S(v0) - S'(v0)(v1 - v0)|. A step that jumps
over a reversal can have a small error and a tangent that never saw the reversal; the third bound
makes every step resolve the layer in which the sign changes.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from tp_jax.model.friction import smooth_sign
from tp_jax.simulation.tableau import ROS34PW2

#: field(t, y, p, piece, left) -> derivatives of y; y and p are tuples of arrays (L,).
Field = Callable[..., tuple]


class Tolerances(NamedTuple):
    """Tolerances of a step: angles [rad], velocities [rad/s], tangents (relative), friction."""

    angle: float = 1e-6
    velocity: float = 1e-4
    tangent: float = 1e-2
    friction: float = 0.15


class Lanes(NamedTuple):
    """What the engine integrates.

    A lane takes several windows one after the other, so that all lanes are busy whatever the
    windows' length: at a sample marked as a start the state is set anew, not integrated.

    ts: (n, L) sample times [s], the last repeated where a lane has fewer; count: (L,) number of
    samples; start: (n, L) whether a window starts there; states: (n, c, L) state at each start;
    pieces: (n - 1, 4, L) cubic coefficients of a measured drive, or None.
    """

    ts: Float[Array, "n L"]
    count: Int[Array, " L"]
    start: Bool[Array, "n L"]
    states: Float[Array, "n c L"]
    pieces: Float[Array, "n-1 4 L"] | None


class Motion(NamedTuple):
    """A vector field and the places in `p` that it depends on.

    field(t, y, p, piece, left) gives the derivatives of y, elementwise over lanes; y and p are
    tuples of arrays (L,).
    """

    field: Field
    depends: tuple[int, ...]


class Integrated(NamedTuple):
    """States and tangents at the samples, lanes first.

    y: (L, n, c) components; s: (L, n, c, c + d) their derivatives with respect to the components
    at the window's start and the chosen directions; steps: (L,); complete: (L,) False where the
    lane ran out of steps.
    """

    y: Float[Array, "L n c"]
    s: Float[Array, "L n c m"]
    steps: Int[Array, " L"]
    complete: Bool[Array, " L"]


def integrate(
    motions: Sequence[Motion],
    p: tuple[Float[Array, " L"], ...],
    lanes: Lanes,
    eps: tuple[int, int],
    choice: Int[Array, ""],
    directions: Int[Array, " d"],
    tolerances: Tolerances = Tolerances(),  # noqa: B008
    max_steps: int = 20_000,
) -> Integrated:
    """Integrates all lanes over their samples.

    Args:
        motions: vector fields, each with some of the effects.
        p: every parameter of the model, one value per lane.
        lanes: sample times and window starts.
        eps: places in `p` of the two smoothing slopes.
        choice: which of the motions; data, so that one program serves all. Most of a step's cost
            is effects.
        directions: places in `p` of the parameters to differentiate by; data, not structure.
        tolerances: see `Tolerances`.
        max_steps: limit of loop passes; what is unfinished then is marked.
    """
    y0 = lanes.states[0]
    nc, n_lanes = y0.shape
    nd = directions.size
    nt = nc + nd
    n = lanes.ts.shape[0]
    lane = jnp.arange(n_lanes)
    s0 = jnp.concatenate([jnp.eye(nc), jnp.zeros((nc, nd))], axis=1)
    s0 = jnp.broadcast_to(s0[:, :, None], (nc, nt, n_lanes)).astype(y0.dtype)
    weights = jnp.array([tolerances.angle] * 2 + [tolerances.velocity] * 2)
    weights = jnp.concatenate([weights, jnp.full(nc - 4, tolerances.angle)])[:, None]
    partials = jax.jit(_partials, static_argnums=0)
    step = _make_step(_switched(motions, partials, choice), directions)

    first = 0.1 * (lanes.ts[1] - lanes.ts[0])

    def sample_time(i):
        return jnp.take_along_axis(lanes.ts, i[None], axis=0)[0]

    def body(carry):
        count, t, i, h, y, s, out_y, out_s, steps = carry
        active = unfinished(i, y)
        target = jnp.minimum(i + 1, n - 1)
        end = sample_time(target)
        fresh = active & lanes.start[target, lane]
        rest = jnp.where(fresh, 0.0, end - t)
        land = h >= rest * (1.0 - 1e-9)
        # Two halves rather than a full step and a sliver.
        used = jnp.where(land, rest, jnp.where(2.0 * h > rest, 0.5 * rest, h))
        used = jnp.where(active & ~fresh, used, 0.0)
        if lanes.pieces is None:
            piece, left = None, None
        else:
            index = jnp.minimum(i, n - 2)
            piece = lanes.pieces[index, :, lane].T
            left = sample_time(index)
        y_new, s_new, y_err, s_err = step(t, y, s, used, p, piece, left)
        ratio = jnp.max(jnp.abs(y_err) / weights, axis=0)
        if nd:
            # Those of the window's state, against the largest of their kind: they start at one,
            # so that a relative error means something (a parameter's start at zero), and those
            # of a stuck rider vanish.
            for rows in (slice(0, 2), slice(2, 4)):
                scale = jnp.maximum(jnp.max(jnp.abs(s_new[rows, :nc]), axis=(0, 1)), 0.1)
                worst = jnp.max(jnp.abs(s_err[rows, :nc]), axis=(0, 1))
                ratio = jnp.maximum(ratio, worst / (scale * tolerances.tangent))
        for k, c in ((eps[0], 2), (eps[1], 3)):
            old, new = smooth_sign(y[c], p[k]), smooth_sign(y_new[c], p[k])
            slope = (2.0 / jnp.pi) * p[k] / (1.0 + (p[k] * y[c]) ** 2)
            bend = jnp.abs(new - old - slope * (y_new[c] - y[c]))
            ratio = jnp.maximum(ratio, bend / tolerances.friction)
        good = jnp.isfinite(ratio)
        factor = 0.9 * jnp.maximum(ratio, 1e-8) ** (-1.0 / ROS34PW2.order)
        factor = jnp.where(good, jnp.clip(factor, 0.1, 6.0), 0.1)
        # Below a picosecond only rounding is left: go on rather than stand still.
        accept = active & ((ratio <= 1.0) | (used < 1e-12))
        land = land | fresh
        grown = jnp.where(land | (used < h), jnp.maximum(h, used * factor), used * factor)
        h = jnp.where(accept, grown, used * jnp.minimum(factor, 0.7))
        h = jnp.where(fresh, first, jnp.where(active, h, 1.0))
        y = jnp.where(fresh, lanes.states[target, :, lane].T, jnp.where(accept, y_new, y))
        s = jnp.where(fresh, s0, jnp.where(accept, s_new, s))
        landed = accept & land
        t = jnp.where(landed, end, jnp.where(accept, t + used, t))
        # Written every pass; the last write before moving on is the one on the sample.
        out_y = out_y.at[lane, target].set(y.T)
        out_s = out_s.at[lane, target].set(s.transpose(2, 0, 1))
        i = i + landed
        return count + 1, t, i, h, y, s, out_y, out_s, steps + active

    def unfinished(i, y):  # a lane that is not finite will never be done
        return (i < lanes.count - 1) & jnp.all(jnp.isfinite(y), axis=0)

    def go_on(carry):
        return jnp.any(unfinished(carry[2], carry[4])) & (carry[0] < max_steps)

    out_y = jnp.zeros((n_lanes, n, nc)).at[:, 0].set(y0.T)
    out_s = jnp.zeros((n_lanes, n, nc, nt)).at[:, 0].set(s0.transpose(2, 0, 1))
    begin = (
        0, lanes.ts[0], jnp.zeros(n_lanes, int), first, y0, s0, out_y, out_s,
        jnp.zeros(n_lanes, int),
    )  # fmt: skip
    end = jax.lax.while_loop(go_on, body, begin)
    return Integrated(end[6], end[7], end[8], end[2] >= lanes.count - 1)


def _partials(motion: Motion, t, y, p, piece, left):
    """Derivatives of a field with respect to each component and each parameter.

    One tangent at a time, so that only what depends on it is differentiated.

    Returns:
        value (c, L); by state, a list of (c, L); by parameter (c, P, L).
    """
    field = motion.field
    value = jnp.stack(field(t, y, p, piece, left))
    one = jnp.ones_like(t)

    def by_component(k):
        f = lambda x: jnp.stack(field(t, (*y[:k], x, *y[k + 1 :]), p, piece, left))  # noqa: E731
        return jax.jvp(f, (y[k],), (one,))[1]

    def by_parameter(k):
        if k not in motion.depends:
            return jnp.zeros_like(value)
        f = lambda x: jnp.stack(field(t, y, (*p[:k], x, *p[k + 1 :]), piece, left))  # noqa: E731
        return jax.jvp(f, (p[k],), (one,))[1]

    states = [by_component(k) for k in range(len(y))]
    parameters = jnp.stack([by_parameter(k) for k in range(len(p))], axis=1)
    return value, states, parameters


def _switched(motions: Sequence[Motion], partials: Callable, choice: Array) -> Callable:
    """Partials of the chosen motion."""
    branches = [lambda *a, m=m: partials(m, *a) for m in motions]
    return lambda *args: jax.lax.switch(choice, branches, *args)


def _make_step(partials: Callable, directions: Array) -> Callable:
    """The step function: state, tangents and their embedded errors."""
    tab = ROS34PW2

    def step(t, y, s, h, p, piece, left):
        nc = s.shape[0]
        gh = tab.gamma * h
        value, jac, par = partials(t, tuple(y), p, piece, left)
        solve = _closed_form(jac, gh)
        ky: list[Array] = []
        ks: list[Array] = []
        for i in range(4):
            if i:
                yi = y + h * _combine(tab.a[i], ky)
                si = s + h * _combine(tab.a[i], ks)
                ti = t + tab.c[i] * h
                value, jac_i, par = partials(ti, tuple(yi), p, piece, left)
            else:
                si, jac_i = s, jac
            rhs = value
            rhs_s = _product(jac_i, si)
            rhs_s = rhs_s.at[:, nc:].add(jnp.take(par, directions, axis=1))
            if i:
                gy, gs = _combine(tab.g[i], ky), _combine(tab.g[i], ks)
                rhs = rhs + h * _product(jac, gy)
                rhs_s = rhs_s + h * _product(jac, gs)
            ky.append(solve(rhs))
            ks.append(solve(rhs_s))
        y_new = y + h * _combine(tab.b, ky)
        s_new = s + h * _combine(tab.b, ks)
        return y_new, s_new, h * _combine(tab.b_error, ky), h * _combine(tab.b_error, ks)

    return step


def _combine(weights, stages: list[Array]) -> Array:
    return sum((w * k for w, k in zip(weights, stages, strict=False) if w), jnp.zeros(()))


def _product(columns: list[Array], x: Array) -> Array:
    """Jacobian (list of columns (c, L)) times x (c, L) or (c, m, L)."""
    if x.ndim == 2:
        return sum(col * x[k] for k, col in enumerate(columns))
    return sum(col[:, None] * x[k][None] for k, col in enumerate(columns))


def _closed_form(columns: list[Array], gh: Array) -> Callable:
    """Solver of (I - gh J) x = r for the pendulum's block, diagonal for own states of effects."""
    rate = columns[2][0]
    q = [[columns[j][2 + i] for j in (0, 1)] for i in (0, 1)]
    v = [[columns[2 + j][2 + i] for j in (0, 1)] for i in (0, 1)]
    w = [
        [(1.0 if i == j else 0.0) - gh * v[i][j] - gh**2 * rate * q[i][j] for j in (0, 1)]
        for i in (0, 1)
    ]
    det = w[0][0] * w[1][1] - w[0][1] * w[1][0]
    inverse = [[w[1][1] / det, -w[0][1] / det], [-w[1][0] / det, w[0][0] / det]]
    own = [1.0 / (1.0 - gh * columns[k][k]) for k in range(4, len(columns))]

    def solve(r: Array) -> Array:
        r0 = r[2] + gh * (q[0][0] * r[0] + q[0][1] * r[1])
        r1 = r[3] + gh * (q[1][0] * r[0] + q[1][1] * r[1])
        k0 = inverse[0][0] * r0 + inverse[0][1] * r1
        k1 = inverse[1][0] * r0 + inverse[1][1] * r1
        rest = [own[k - 4] * r[k] for k in range(4, len(columns))]
        return jnp.stack([r[0] + gh * rate * k0, r[1] + gh * rate * k1, k0, k1, *rest])

    return solve
