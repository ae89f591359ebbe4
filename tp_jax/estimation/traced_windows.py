"""The residuals of all windows as one function that JAX can trace, for methods of optimistix.

Window states follow the unknowns as the linearisation at a reference says, so that they are no
unknowns of the method; around the reference the function is what `variable_projection` minimises.
The Jacobian comes with the residuals, from the same integration.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from tp_jax.estimation.layout import Layout, Values
from tp_jax.estimation.linearisation import columns
from tp_jax.estimation.problem import LANES, Problem
from tp_jax.estimation.program import Block, linearise
from tp_jax.estimation.robust import Loss, robustify
from tp_jax.simulation.lanes import Tolerances


class Traced(NamedTuple):
    """What `residuals` needs besides the unknowns; blocks are stacked along the first axis.

    table: (P, R) all numbers; rows: (u,) slots of the unknowns; own: (u,) the recording of each, -1
    for all; place: (u,) of each among the directions; directions: (d,) slots; typical: (u,) and
    logs, asinhs: (u,) 1.0 for those whose coordinate is a logarithm or an asinh, the coordinates;
    at: (u,) coordinates of the reference; recording: (b, L); states: (b, n, 4, L) at windows'
    starts; gain: (b, n, 4, L, u) how they follow; begin: (b, n, L) first sample of the window each
    sample is of; anchors: (u,) centres and (u,) weights 1/sd, 0 for none.
    """

    table: Float[Array, "P R"]
    rows: Int[Array, " u"]
    own: Int[Array, " u"]
    place: Int[Array, " u"]
    directions: Int[Array, " d"]
    typical: Float[Array, " u"]
    logs: Float[Array, " u"]
    asinhs: Float[Array, " u"]
    at: Float[Array, " u"]
    recording: Int[Array, "b L"]
    states: Float[Array, "b n 4 L"]
    gain: Float[Array, "b n 4 L u"]
    begin: Int[Array, "b n L"]
    blocks: Block
    centre: Float[Array, " u"]
    weight: Float[Array, " u"]


def traced(
    problem: Problem, values: Values, states: np.ndarray, gain: np.ndarray, unknowns, specs,
    anchors, blocks: int,
) -> Traced:  # fmt: skip
    """The windows at a reference.

    Args:
        problem: recordings in windows.
        values, states: the reference.
        gain: (w, 4, u) how states follow the unknowns' coordinates.
        unknowns: what is searched. specs: their parameters. anchors: their priors.
        blocks: how many there are to be, those of other horizons included; the rest is empty.
    """
    n, count = problem.capacity, len(unknowns)
    recording = np.zeros((blocks, LANES), int)
    start_states = np.zeros((blocks, n, 4, LANES))
    start_gain = np.zeros((blocks, n, 4, LANES, count))
    begin = np.zeros((blocks, n, LANES), int)
    found = problem.blocks()
    for b, (which, places, _) in enumerate(found):
        for i, (_, lane, at, _) in zip(which, places, strict=True):
            recording[b, lane] = problem.windows.recording[i]
            start_states[b, at, :, lane] = states[i]
            start_gain[b, at, :, lane] = gain[i]
            begin[b, at : at + problem.windows.count[i], lane] = at
    data = [block for _, _, block in found]
    empty = jax.tree.map(jnp.zeros_like, data[0])
    empty = empty._replace(count=jnp.ones_like(data[0].count), ts=data[0].ts)
    data += [empty] * (blocks - len(data))
    slots = columns(unknowns)
    centre, weight = np.zeros(count), np.zeros(count)
    for a in anchors:
        i = list(unknowns).index(a.unknown)
        centre[i], weight[i] = a.centre, 1.0 / a.sd
    at = [float(s.to_coordinate(v)) for s, v in zip(specs, values.pick(unknowns), strict=True)]
    index = problem.layout.index
    arrays = Traced(
        table=values.table,
        rows=np.array([index[u.name] for u in unknowns]),
        own=np.array([-1 if u.recording is None else u.recording for u in unknowns]),
        place=np.array([slots.index(u.name) for u in unknowns]),
        directions=np.array([index[s] for s in slots]),
        typical=np.array([s.typical for s in specs]),
        logs=np.array([float(s.transform == "log") for s in specs]),
        asinhs=np.array([float(s.transform == "asinh") for s in specs]),
        at=np.array(at), recording=recording, states=start_states, gain=start_gain, begin=begin,
        blocks=jax.tree.map(lambda *x: jnp.stack(x), *data), centre=centre, weight=weight,
    )  # fmt: skip
    return jax.tree.map(jnp.asarray, arrays)


def evaluate(
    layout: Layout,
    tolerances: Tolerances,
    ids: frozenset[str],
    loss: Loss,
    u: Float[Array, " u"],
    t: Traced,
) -> tuple[Float[Array, " r"], Float[Array, "r u"]]:
    """All residuals in units of the noise, priors last, and their derivatives by coordinates u.

    Not a number where a window cannot be integrated: a method then takes a shorter step.
    """
    log, asinh = t.logs > 0.0, t.asinhs > 0.0
    bent = jnp.where(asinh, u, 0.0)
    x = jnp.where(
        log, jnp.exp(jnp.where(log, u, 0.0)), jnp.where(asinh, jnp.sinh(bent), u) * t.typical
    )
    slope = jnp.where(log, x, t.typical * jnp.cosh(bent))
    recordings = jnp.arange(t.table.shape[1])
    mine = (t.own[:, None] < 0) | (t.own[:, None] == recordings)  # (u, R)
    table = t.table
    for j in range(t.rows.size):
        row = jnp.where(mine[j], x[j], table[t.rows[j]])
        table = table.at[t.rows[j]].set(row)

    def one(args):
        recording, states, gain, begin, block = args
        x0 = states + jnp.einsum("nclu,u->ncl", gain, u - t.at)
        out = linearise(
            layout, tolerances, ids, table[:, recording], x0, block, t.directions
        )  # fmt: skip
        lane = jnp.arange(LANES)
        follow = gain.transpose(1, 0, 2, 3)[:, begin, lane]  # (4, n, L, u)
        by = slope * mine[:, recording].T[:, None, None, :]  # (L, 1, 1, u)
        jac = out.jac[..., 4:][..., t.place] * by
        jac = jac + jnp.einsum("lnck,knlu->lncu", out.jac[..., :4], follow)
        prior = out.prior_jac[..., 4:][..., t.place] * by
        follow = follow[:, block.begins, lane]
        prior = prior + jnp.einsum("lnck,knlu->lncu", out.prior_jac[..., :4], follow)
        r, factor = robustify(out.r, loss, jnp)
        r = jnp.concatenate([r.reshape(-1), out.prior_r.reshape(-1)])
        jac = jac * factor[..., None]
        J = jnp.concatenate([jac.reshape(-1, u.size), prior.reshape(-1, u.size)])
        return jnp.where(out.complete.all(), r, jnp.nan), J

    r, J = jax.lax.map(one, (t.recording, t.states, t.gain, t.begin, t.blocks))
    r = jnp.append(r.reshape(-1), (u - t.centre) * t.weight)
    return r, jnp.concatenate([J.reshape(-1, u.size), jnp.diag(t.weight)])
