"""The residuals of all windows as one function of the unknowns, which JAX can trace.

Methods of optimistix minimise it. The windows' states are no unknowns of theirs: inside the
function each window's state is put where the window fits best, so that what the method sees is the
sum of squares that `variable_projection` minimises. The Jacobian is Kaufman's: the columns by the
unknowns, less what the states make up for; a state in a kink makes up along it alone (see
`window_states`). It comes from the same integration as the residuals.

Source: Golub and Pereyra (1973), SIAM J. Numer. Anal. 10:413; Kaufman (1975), BIT 15:49.
"""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from tp_jax.estimation.layout import Layout, Values
from tp_jax.estimation.linearisation import columns
from tp_jax.estimation.problem import LANES, Problem
from tp_jax.estimation.program import Block, linearise
from tp_jax.estimation.robust import Loss, robustify
from tp_jax.estimation.window_states import KINK, MAX_STATE_STEP
from tp_jax.model.arrays import AnyArray

#: Steps of the windows' states in one evaluation. Three are enough unless the rider of a window
#: just sticks; such a window never ends, and all others would wait for it.
ROUNDS = 4

TINY = 1e-300  # in place of a divisor of zero
NO_SLOTS = np.zeros(0, int)  # directions of a pass that looks at the windows' states alone


class Unfolded(NamedTuple):
    """One block of windows (lanes last) and where each sample belongs.

    recording: (L,) of each lane; states: (L, W, 4) at the windows' starts at the reference, W
    windows a lane; gain: (L, W, 4, u) how they follow the unknowns; window: (n, L) window of each
    sample in its lane; there: (L, W) whether there is one; previous, before, scale: (n, 2, L)
    weights of the noise's whitening (see `_whitened`); block: the data.
    """

    recording: Int[AnyArray, " L"]
    states: Float[AnyArray, "L W 4"]
    gain: Float[AnyArray, "L W 4 u"]
    window: Int[AnyArray, "n L"]
    there: Bool[AnyArray, "L W"]
    previous: Float[AnyArray, "n 2 L"]
    before: Float[AnyArray, "n 2 L"]
    scale: Float[AnyArray, "n 2 L"]
    block: Block


class Coordinates(NamedTuple):
    """Map from unknowns to numbers of the model.

    rows: (u,) slots; own: (u,) the recording of each, -1 for all; place: (u,) of each among the
    directions; typical: (u,); logs, asinhs: (u,) bool, whose coordinate is a logarithm or an asinh.
    """

    rows: Int[Array, " u"]
    own: Int[Array, " u"]
    place: Int[Array, " u"]
    typical: Float[Array, " u"]
    logs: Bool[Array, " u"]
    asinhs: Bool[Array, " u"]

    def values(self, u: Float[Array, " u"]) -> tuple[Float[Array, " u"], Float[Array, " u"]]:
        """SI values of coordinates, and their slopes."""
        bent = jnp.where(self.asinhs, u, 0.0)
        exponential = jnp.exp(jnp.where(self.logs, u, 0.0))
        x = jnp.where(
            self.logs, exponential, jnp.where(self.asinhs, jnp.sinh(bent), u) * self.typical
        )
        return x, jnp.where(self.logs, x, self.typical * jnp.cosh(bent))


class WindowResiduals(eqx.Module):
    """Residuals of all windows at unknowns, the windows' states where each fits best.

    Attributes:
        layout, ids, loss, coloured: the model's structure, the effects that the program carries,
            the loss, and whether noise is to be whitened; static.
        tolerances: of the integration.
        table: (P, R) all numbers, those of the unknowns to be overwritten.
        directions: (d,) slots of the unknowns.
        coordinates: of the unknowns.
        blocks: the data, stacked along the first axis.
        enough: drop of a window's sum of squares for which its state is not moved.
        reference: (u,) coordinates from which the windows' states begin to follow.
        centre, weight: (u,) of the priors, 1/sd, 0 where there is none.
    """

    layout: Layout = eqx.field(static=True)
    ids: frozenset[str] = eqx.field(static=True)
    loss: Loss = eqx.field(static=True)
    coloured: bool = eqx.field(static=True)
    tolerances: Float[Array, " 2"]
    table: Float[Array, "P R"]
    directions: Int[Array, " d"]
    coordinates: Coordinates
    blocks: Unfolded
    enough: Float[Array, ""]
    reference: Float[Array, " u"]
    centre: Float[Array, " u"]
    weight: Float[Array, " u"]

    def evaluate(self, u: Float[Array, " u"]) -> tuple[Float[Array, " r"], Float[Array, "r u"]]:
        """Residuals in units of the noise, priors last, and their derivatives by coordinates u.

        Not a number where a window cannot be integrated: a method then takes a shorter step.
        """
        c = self.coordinates
        x, slope = c.values(u)
        mine = (c.own[:, None] < 0) | (c.own[:, None] == jnp.arange(self.table.shape[1]))  # (u, R)
        table = self.table
        for j in range(c.rows.size):
            table = table.at[c.rows[j]].set(jnp.where(mine[j], x[j], table[c.rows[j]]))

        def one(b: Unfolded):
            p = table[:, b.recording]
            begin = b.states + jnp.einsum("lwxu,u->lwx", b.gain, u - self.reference)
            states = self._best_states(p, begin, b)
            seen = self._pass(p, states, b, self.directions)
            by = slope * mine[:, b.recording].T[:, None, :]  # (L, 1, u)
            direct = seen.jac[..., 4:][..., c.place] * by[:, :, None]
            prior = seen.prior_jac[..., 4:][..., c.place] * by[:, :, None]
            own, prior_own = seen.jac[..., :4], seen.prior_jac[..., :4]
            cross = _by_window(jnp.einsum("lncx,lncu->lnxu", own, direct), b)
            cross = cross + jnp.einsum("lwcx,lwcu->lwxu", prior_own, prior)
            gain = self._followed(seen, cross)
            lane = jnp.arange(LANES)[:, None]
            jac = direct + jnp.einsum("lncx,lnxu->lncu", own, gain[lane, b.window.T])
            prior = prior + jnp.einsum("lwcx,lwxu->lwcu", prior_own, gain)
            r = jnp.concatenate([seen.r.reshape(-1), seen.prior_r.reshape(-1)])
            J = jnp.concatenate([jac.reshape(-1, u.size), prior.reshape(-1, u.size)])
            return jnp.where(seen.complete.all(), r, jnp.nan), J

        r, J = jax.lax.map(one, self.blocks)
        r = jnp.append(r.reshape(-1), (u - self.centre) * self.weight)
        return r, jnp.concatenate([J.reshape(-1, u.size), jnp.diag(self.weight)])

    def _followed(self, seen: "_Seen", cross: Float[Array, "L W 4 u"]) -> Float[Array, "L W 4 u"]:
        """Computes how the windows' states follow the unknowns: along a kink where they lie in one,
        as in `elimination.eliminate`."""
        g = seen.gradient
        solved = -_solved(seen.information, jnp.concatenate([g[..., None], cross], axis=-1))
        step, gain = solved[..., 0], solved[..., 1:]
        promise = -jnp.sum(g * step, axis=-1)
        across = jnp.einsum("lwx,lwxu->lwu", step, cross) / jnp.maximum(promise, TINY)[..., None]
        held = gain + step[..., None] * across[..., None, :]
        kinked = promise > jnp.maximum(self.enough, KINK)
        return jnp.where(kinked[..., None, None], held, gain)

    def _best_states(
        self, p: Float[Array, "P L"], states: Float[AnyArray, "L W 4"], b: Unfolded
    ) -> Float[AnyArray, "L W 4"]:
        """States (L, W, 4) from which no window gains much: Gauss-Newton steps, each its own.

        A step that was refused tells the slope behind a kink, if there is one; the next one goes
        down on both sides, half as far.
        """
        largest = jnp.asarray(MAX_STATE_STEP)

        def look(states):
            seen = self._pass(p, states, b, jnp.asarray(NO_SLOTS))
            cost = jnp.where(seen.complete[:, None], seen.cost, jnp.inf)
            return cost, seen.gradient, seen.information

        def steps(carry):
            """Steps of the windows that have something to gain, and which these are."""
            _, _, beyond, cost, g, H = carry
            both = _solved(H, jnp.stack([g, beyond], axis=-1))
            there, back = both[..., 0], both[..., 0] - both[..., 1]
            across = jnp.sum((g - beyond) * back, axis=-1)
            part = jnp.clip(jnp.sum(g * back, axis=-1) / jnp.maximum(across, TINY), 0.0, 1.0)
            mean, step = g - part[..., None] * (g - beyond), there - part[..., None] * back
            promise = jnp.sum(mean * step, axis=-1)
            return -step, b.there & jnp.isfinite(cost) & (promise > self.enough)

        def go_on(carry):
            count, inner = carry
            return (count < ROUNDS) & jnp.any(steps(inner)[1])

        def move(carry):
            count, (states, share, beyond, cost, g, H) = carry
            step, open_ = steps((states, share, beyond, cost, g, H))
            step = jnp.clip(share[..., None] * step, -largest, largest)
            step = jnp.where(open_[..., None], step, 0.0)
            new_cost, new_g, new_H = look(states + step)
            better = open_ & (new_cost < cost)
            worse = open_ & ~better
            share = jnp.where(better, jnp.minimum(2.0 * share, 1.0), share)
            share = jnp.where(worse, 0.5 * share, share)
            known = worse & jnp.isfinite(new_cost)
            beyond = jnp.where(known[..., None], new_g, beyond)
            # until a step is refused there is no other side
            beyond = jnp.where((better & (share == 1.0))[..., None], new_g, beyond)
            states = jnp.where(better[..., None], states + step, states)
            cost = jnp.where(better, new_cost, cost)
            g = jnp.where(better[..., None], new_g, g)
            H = jnp.where(better[..., None, None], new_H, H)
            return count + 1, (states, share, beyond, cost, g, H)

        cost, g, H = look(states)
        begin = (states, jnp.ones(b.there.shape), g, cost, g, H)
        return jax.lax.while_loop(go_on, move, (0, begin))[1][0]

    def _pass(
        self,
        p: Float[Array, "P L"],
        states: Float[AnyArray, "L W 4"],
        b: Unfolded,
        directions: Int[Array, " d"],
    ) -> "_Seen":
        """One integration of a block; residuals whitened and under the loss."""
        lane = jnp.arange(LANES)
        x0 = states[lane, b.window].transpose(0, 2, 1)
        out = linearise(self.layout, self.tolerances, self.ids, p, x0, b.block, directions)
        r, jac = out.r, out.jac
        if self.coloured:
            both = _whitened(jnp.concatenate([r[..., None], jac], axis=-1), b)
            r, jac = both[..., 0], both[..., 1:]
        r, factor = robustify(r, self.loss, jnp)
        jac = jac * factor[..., None]
        own, prior_own = jac[..., :4], out.prior_jac[..., :4]
        cost = _by_window(jnp.sum(r**2, axis=-1)[..., None], b)[..., 0]
        g = _by_window(jnp.einsum("lncx,lnc->lnx", own, r), b)
        H = _by_window(jnp.einsum("lncx,lncy->lnxy", own, own), b)
        return _Seen(
            r,
            jac,
            out.prior_r,
            out.prior_jac,
            out.complete,
            cost + jnp.sum(out.prior_r**2, axis=-1),
            g + jnp.einsum("lwcx,lwc->lwx", prior_own, out.prior_r),
            H + jnp.einsum("lwcx,lwcy->lwxy", prior_own, prior_own),
        )


class _Seen(NamedTuple):
    """A pass over a block: rows of samples and of priors; by window (L, W) its sum of squares, and
    gradient and information of its state."""

    r: Float[Array, "L n 2"]
    jac: Float[Array, "L n 2 m"]
    prior_r: Float[AnyArray, "L W 4"]
    prior_jac: Float[AnyArray, "L W 4 m"]
    complete: Bool[AnyArray, " L"]
    cost: Float[Array, "L W"]
    gradient: Float[Array, "L W 4"]
    information: Float[Array, "L W 4 4"]


def _by_window(x: Float[Array, "L n ..."], b: Unfolded) -> Float[Array, "L W ..."]:
    """Sums over the samples of each window."""
    lanes, count = b.there.shape
    where = (jnp.arange(lanes)[:, None] * count + b.window.T).reshape(-1)
    flat = x.reshape(where.size, *x.shape[2:])
    return jax.ops.segment_sum(flat, where, lanes * count).reshape(lanes, count, *x.shape[2:])


def _solved(H: Float[Array, "L W 4 4"], right: Float[Array, "L W 4 n"]) -> Float[Array, "L W 4 n"]:
    """Information's inverse times right-hand sides; nothing for a window that says nothing."""
    largest = jnp.einsum("lwii->lwi", H).max(axis=-1)
    floor = jnp.where(largest > 0.0, 1e-12 * largest, 1.0)
    return jnp.linalg.solve(H + floor[..., None, None] * jnp.eye(H.shape[-1]), right)


def _whitened(x: Float[Array, "L n 2 q"], b: Unfolded) -> Float[Array, "L n 2 q"]:
    """Rows whose noise is uncorrelated, as `Colour.whiten` makes them, window by window.

    The innovations of an ARMA(1, 1): e_t = x_t - rho x_(t-1) - theta_t e_(t-1).
    """

    def step(carry, row):
        x_before, e_before = carry
        x, previous, before, scale = row
        e = x - previous[..., None] * x_before - before[..., None] * e_before
        return (x, e), e * scale[..., None]

    rows = x.transpose(1, 2, 0, 3)  # (n, 2, L, q)
    zero = jnp.zeros_like(rows[0])
    _, white = jax.lax.scan(step, (zero, zero), (rows, b.previous, b.before, b.scale))
    return white.transpose(2, 0, 1, 3)


def window_residuals(
    problem: Problem,
    values: Values,
    states: np.ndarray,
    gain: np.ndarray,
    unknowns,
    specs,
    priors,
    *,
    blocks: int,
    loss: Loss = "linear",
    enough: float = 0.01,
) -> WindowResiduals:
    """The function at a reference.

    Args:
        problem: recordings in windows.
        values: all numbers that are not searched.
        states: (w, 4) where the windows' states begin in every evaluation,
        gain: (w, 4, u) and how they follow the unknowns' coordinates from those of `values` on.
        unknowns: what is searched. specs: their parameters. priors: of some of them.
        blocks: how many there are to be, those of other horizons included; the rest is empty.
        loss: of a residual.
        enough: see `WindowResiduals`.
    """
    found = [_unfolded(problem, states, gain, *each) for each in problem.blocks()]
    empty = jax.tree.map(np.zeros_like, found[0])
    first = found[0].block
    empty = empty._replace(
        scale=np.ones_like(empty.scale),
        block=empty.block._replace(count=np.ones_like(first.count), ts=first.ts),
    )
    found += [empty] * (blocks - len(found))
    slots, index = columns(unknowns), problem.layout.index
    directions = np.array([index[s] for s in slots], dtype=int)
    centre, weight = np.zeros(len(unknowns)), np.zeros(len(unknowns))
    for a in priors:
        i = list(unknowns).index(a.unknown)
        centre[i], weight[i] = a.mean, 1.0 / a.sd
    asked = problem.programs.asked(directions.tolist())
    return WindowResiduals(
        layout=problem.layout,
        ids=problem.programs.cover(problem.programs.active(values.table), asked),
        loss=loss,
        coloured=problem.coloured,
        tolerances=jnp.asarray(np.array(problem.tolerances, float)),
        table=jnp.asarray(values.table),
        directions=jnp.asarray(directions),
        coordinates=Coordinates(
            rows=jnp.asarray([index[u.name] for u in unknowns]),
            own=jnp.asarray([-1 if u.recording is None else u.recording for u in unknowns]),
            place=jnp.asarray([slots.index(u.name) for u in unknowns]),
            typical=jnp.asarray([s.typical for s in specs]),
            logs=jnp.asarray([s.transform == "log" for s in specs]),
            asinhs=jnp.asarray([s.transform == "asinh" for s in specs]),
        ),
        blocks=jax.tree.map(lambda *x: jnp.stack(x), *found),
        enough=jnp.asarray(enough),
        reference=jnp.asarray(
            [float(s.to_coordinate(v)) for s, v in zip(specs, values.pick(unknowns), strict=True)]
        ),
        centre=jnp.asarray(centre),
        weight=jnp.asarray(weight),
    )


def _unfolded(
    problem: Problem,
    states: np.ndarray,
    gain: np.ndarray,
    which: np.ndarray,
    places: np.ndarray,
    block: Block,
) -> Unfolded:
    """Returns the places of the windows of a block, and their noise."""
    n, count = problem.capacity, block.begins.shape[0]
    recording, start = np.zeros(LANES, int), np.zeros((LANES, count, 4))
    follow = np.zeros((LANES, count, *gain.shape[1:]))
    window, there = np.zeros((n, LANES), int), np.zeros((LANES, count), bool)
    previous, before = np.zeros((n, 2, LANES)), np.zeros((n, 2, LANES))
    scale = np.ones((n, 2, LANES))
    for i, (_, lane, at, rank) in zip(which, places, strict=True):
        size = int(problem.windows.count[i])
        span = slice(at, at + size)
        r = recording[lane] = problem.windows.recording[i]
        start[lane, rank], there[lane, rank] = states[i], True
        follow[lane, rank] = gain[i]
        window[span, lane] = rank
        window[at + size :, lane] = rank  # what comes after the last one weighs nothing
        for c, colour in enumerate(problem.prepared[r].colour):
            rho, theta, innovation = colour.innovations(size)
            previous[span, c, lane], before[span, c, lane] = rho, theta
            scale[span, c, lane] = innovation
    return Unfolded(
        recording,
        start,
        follow,
        window,
        there,
        previous,
        before,
        scale,
        block,
    )
