"""Log density of the unknowns given the windows, with its gradient, as one JAX function.

Window states are optimised at every point (one Gauss-Newton step from where the fit's own
linearisation puts them), so that the density is a profile over them; half the sum of squares is
tempered by the inflation that profiles use. Flat priors on the friction coefficients, flat in the
logarithm on what is positive, those of the campaign where it has any, and the guard on T0, without
which nothing would end where T0 is unknown.

Coordinates z are white about the fit: unknowns in logarithms (nuisances in typical sizes), turned
and scaled by the inverse information. A sampler then needs no mass matrix of its own.
"""

import dataclasses
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from tp_jax.estimation.baseline import Setting
from tp_jax.estimation.elimination import eliminate
from tp_jax.estimation.layout import Layout
from tp_jax.estimation.least_squares import Fit, parameter
from tp_jax.estimation.least_squares import fit as fit_windows
from tp_jax.estimation.problem import LANES, columns, spread
from tp_jax.estimation.program import NONE, Block, linearise
from tp_jax.identifiability.information import inverse
from tp_jax.identifiability.profile_likelihood import levels_of
from tp_jax.model.parameters import NUISANCES
from tp_jax.simulation.lanes import Tolerances

PRIOR_INFORMATION = 0.25
"""Added to the information along each axis: no direction is scaled by more than a factor e^2."""

IMPOSSIBLE = -1e12
"""Log density where a window cannot be integrated."""

_NUISANCES = frozenset(p.name for p in NUISANCES)


class Part(NamedTuple):
    """One block of windows: its data, and where each window (w,) stands in it.

    lane, at, rank, count: (w,); p: (P, L) numbers of the lanes; slots: (u,) of the unknowns;
    states: (w, 4) at the fit; gain: (w, 4, u) how they follow the unknowns.
    """

    block: Block
    lane: Array
    at: Array
    rank: Array
    count: Array
    p: Array
    states: Array
    gain: Array


class Data(NamedTuple):
    """Everything that `density` needs besides z: arrays only, passed to compiled code.

    parts: blocks; slots: (u,); logs: (u,) bool; base: (u,) values at the fit; units: (u,) steps of
    coordinates that are no logarithms; turn: (u, u) columns from white coordinates; flat: (u,) 1
    where the prior is flat in the value; centres, weights: (u,) priors in estimation coordinates;
    temper: by which sums of squares are divided.
    """

    parts: tuple[Part, ...]
    slots: Array
    logs: Array
    base: Array
    units: Array
    turn: Array
    flat: Array
    centres: Array
    weights: Array
    temper: Array


@dataclasses.dataclass(frozen=True)
class WindowedDensity:
    """The density of one fit: what it is compiled for (layout, tolerances, longest), its data."""

    layout: Layout
    tolerances: Tolerances
    longest: int
    names: tuple[str, ...]
    data: Data

    def values(self, z: Float[np.ndarray, "... u"]) -> Float[np.ndarray, "... u"]:
        """Unknowns in SI units at white coordinates."""
        return np.asarray(_values(jnp.asarray(z), self.data))

    def of(self, data: Data) -> Any:
        """z (u,) -> log density; differentiable by z. `data` as in the field, traced or not."""
        static = (self.layout, self.tolerances, self.longest)

        @jax.custom_vjp
        def density(z):
            return _evaluate(static, data, z)[0]

        def forward(z):
            return _evaluate(static, data, z)

        density.defvjp(forward, lambda gradient, c: (c * gradient,))
        return density


def windowed_density(fit: Fit, setting: Setting) -> WindowedDensity:
    """The density about a fit.

    Args:
        fit: in windows; its unknowns belong to the whole campaign.
        setting: its campaign.
    """
    problem, unknowns = fit.problem, fit.unknowns
    specs = [parameter(problem, u) for u in unknowns]
    names = tuple(u.name for u in unknowns)
    logs = np.array([n not in _NUISANCES for n in names])
    typical = np.array([s.typical for s in specs])
    value = fit.values.pick(unknowns)
    small = np.array([s.transform == "log" for s in specs]) | ~logs
    base = np.where(small, value, np.maximum(value, 1e-3 * typical))
    units = np.where(logs, base, typical)
    temper = float(np.mean(levels_of(fit, setting)[1]))
    H = fit.eliminated.H.sum(axis=0) * np.outer(units, units) / temper
    turn = np.linalg.cholesky(inverse(H + PRIOR_INFORMATION * np.diag(logs.astype(float))))
    centres, weights = np.zeros(len(names)), np.zeros(len(names))
    for a in fit.anchors:
        i = unknowns.index(a.unknown)
        centres[i], weights[i] = a.centre, 1.0 / a.sd**2
    flat = np.array([s.transform != "log" for s in specs]) & logs
    data = Data(
        _parts(fit), jnp.asarray([problem.layout.index[n] for n in names]), jnp.asarray(logs),
        *(jnp.asarray(x, float) for x in (base, units, turn, flat, centres, weights, temper)),
    )  # fmt: skip
    longest = int(problem.windows.count.max())
    return WindowedDensity(problem.layout, problem.tolerances, longest, names, data)


def _parts(fit: Fit) -> tuple[Part, ...]:
    problem = fit.problem
    # At the end of a fit a window's state may still be far from its best where that gains little,
    # the rate of a body that sticks above all; from there one linearisation would not do.
    best = fit_windows(problem, fit.values, (), fit.states, tolerance=1e-6, relative=0.0)
    states = best.states
    lin = problem.linearise(fit.values, states, columns(fit.unknowns))
    elim = eliminate(lin.r, lin.states_jac, spread(lin, fit.unknowns))
    parts = []
    for which, places, block in problem.blocks():
        _, lane, at, rank = places.T
        p = np.repeat(fit.values.table[:, :1], LANES, axis=1)
        p[:, lane] = fit.values.table[:, problem.windows.recording[which]]
        count, gain = problem.windows.count[which], elim.state_gain[which]
        arrays = (lane, at, rank, count, p, states[which], gain)
        parts.append(Part(block, *(jnp.asarray(a) for a in arrays)))
    return tuple(parts)


def _values(z: Array, data: Data) -> Array:
    y = z @ data.turn.T
    return jnp.where(data.logs, data.base * jnp.exp(y), data.base + data.units * y)


def _evaluate(static: tuple, data: Data, z: Array) -> tuple[Array, Array]:
    """Log density and its gradient by z."""
    layout, tolerances, longest = static
    x = _values(z, data)
    slope = jnp.where(data.logs, x, data.units)
    cost, gradient, complete = 0.0, jnp.zeros_like(x), jnp.asarray(True)
    for part in data.parts:
        c, g, done = _part(layout, tolerances, longest, part, data, x)
        cost, gradient, complete = cost + c, gradient + g, complete & done
    log_density = -0.5 * cost / data.temper
    by_y = -gradient * slope / data.temper
    # Priors: flat in the value is its own Jacobian in the logarithm.
    y = z @ data.turn.T
    log_density = log_density + jnp.sum(data.flat * y)
    by_y = by_y + data.flat
    coordinate = jnp.where(data.logs & (data.flat == 0.0), jnp.log(jnp.maximum(x, 1e-300)), 0.0)
    off = coordinate - data.centres
    log_density = log_density - 0.5 * jnp.sum(data.weights * off**2)
    by_y = by_y - data.weights * off
    usable = complete & jnp.isfinite(log_density) & jnp.all(jnp.isfinite(by_y))
    return (
        jnp.where(usable, log_density, IMPOSSIBLE),
        jnp.where(usable, by_y @ data.turn, 0.0),
    )


def _part(layout, tolerances, longest, part: Part, data: Data, x: Array):
    """Sum of squares of a block at its best states, its half gradient by x, whether all ended."""
    n = part.block.ts.shape[0]
    p = part.p.at[data.slots].set(x[:, None])
    start = part.states + part.gain @ (x - data.base)
    x0 = jnp.zeros((n, 4, part.block.ts.shape[1]))
    x0 = x0.at[part.at, :4, part.lane].set(start)
    out = linearise(layout, tolerances, NONE, p, x0, part.block, data.slots)
    # each window's own rows, padded to the longest
    row = part.at[:, None] + jnp.arange(longest)
    inside = jnp.arange(longest) < part.count[:, None]
    row = jnp.minimum(row, n - 1)
    r = jnp.where(inside[..., None], out.r[part.lane[:, None], row], 0.0)
    jac = jnp.where(inside[..., None, None], out.jac[part.lane[:, None], row], 0.0)
    w = r.shape[0]
    r = jnp.concatenate([r.reshape(w, -1), out.prior_r[part.lane, part.rank]], axis=1)
    jac = jnp.concatenate(
        [jac.reshape(w, -1, jac.shape[-1]), out.prior_jac[part.lane, part.rank]], axis=1
    )
    own, by_x = jac[..., :4], jac[..., 4:]
    hxx = jnp.einsum("wmi,wmj->wij", own, own)
    largest = jnp.max(jnp.diagonal(hxx, axis1=1, axis2=2), axis=1)
    hxx = hxx + jnp.where(largest > 0.0, 1e-12 * largest, 1.0)[:, None, None] * jnp.eye(4)
    gx = jnp.einsum("wmi,wm->wi", own, r)
    step = -jnp.linalg.solve(hxx, gx[..., None])[..., 0]
    cost = jnp.sum(r**2) + jnp.sum(gx * step)
    left = r + jnp.einsum("wmi,wi->wm", own, step)
    gradient = jnp.einsum("wmu,wm->u", by_x, left)
    return cost, gradient, jnp.all(out.complete)
