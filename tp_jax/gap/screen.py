"""All effects judged from one linearisation at a fit.

With the window states eliminated, the sum of squares is quadratic in the unknowns b of the fit
and the amplitudes e of every effect at null. The efficient score of an effect, b re-optimised, is
s = g_e - H_eb H_bb^-1 g_b with information V = H_ee - H_eb H_bb^-1 H_be; its predicted drop of the
sum of squares is s' V^-1 s, or less where that takes an amplitude beyond its bounds (many are at
one at null: no friction gives way by a negative part). What the calibration may have put the angles
off belongs to b, with a prior (`calibration`). The score's covariance is taken from the scatter of
the windows, in blocks of two periods or more, since neighbouring windows are correlated by what the
model lacks.
"""

import dataclasses
from collections.abc import Sequence

import numpy as np

from tp_jax.effects import AnyLaw, Law, laws
from tp_jax.estimation.blocks import blocks_of
from tp_jax.estimation.bounded_step import bounded_step
from tp_jax.estimation.elimination import eliminate
from tp_jax.estimation.fitted import Fit, parameter
from tp_jax.estimation.layout import Unknown
from tp_jax.estimation.linearisation import columns, gathered, places
from tp_jax.estimation.normal_equations import efficient_inverse, scaled_inverse
from tp_jax.estimation.parts import parts, rows_of
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.gap import calibration
from tp_jax.gap.applicability import why_not
from tp_jax.gap.block_information import BlockInformation
from tp_jax.gap.directions import Variant, layers, variants
from tp_jax.gap.rounding import Rounding, coarse_steps, rounding

#: Typical sizes within which an amplitude is expected. It matters where a recording says nothing of
#: its own (the friction of a rider that never slides): it would be sent to a bound, and the step
#: with it to nowhere.
WIDE = 3.0


@dataclasses.dataclass(frozen=True)
class Scored:
    """One effect at one set of shape constants, seen from a fit.

    drop: predicted fall of the sum of squares; estimate: (q,) predicted amplitudes, both within
    the amplitudes' bounds; unbounded: the drop without those; V: (q, q) efficient information;
    blocks: (B, q) efficient scores by block; shift: (u,) predicted move of the fit's unknowns;
    rows: what identifies the columns among all (`Screen.columns`); limits: (q, 2) bounds of the
    amplitudes on this rig.
    """

    variant: Variant
    drop: float
    unbounded: float
    estimate: np.ndarray
    V: np.ndarray
    blocks: np.ndarray
    shift: np.ndarray
    rows: slice
    limits: np.ndarray

    @property
    def id(self) -> str:
        """The effect's id."""
        return self.variant.effect.id


@dataclasses.dataclass(frozen=True)
class Screen:
    """All effects and grid points.

    total: (E,) efficient scores, summed over windows; information: (E, E) over all their columns,
    efficient; by_block: covariances of the blocks' gradients, one more if there is a calibration's
    error, for what that may do to their sum; covariance: (u, u) of the unknowns; rounding: what
    draws the scores instead, where readings are coarse.
    """

    scored: tuple[Scored, ...]
    information: np.ndarray
    by_block: BlockInformation
    not_applicable: dict[str, str]
    total: np.ndarray
    covariance: np.ndarray
    rounding: Rounding | None = None

    def pair(self, limit: int = 12) -> tuple[Scored, Scored, float] | None:
        """The two effects that would help most together, and their predicted drop.

        Of the `limit` best ones, each at its best grid point; None where there are fewer than two.
        What two effects take together may be more than what either seems to take alone.
        """
        ranked = [s for s in self.best() if s.unbounded > 0.0][:limit]
        found = None
        for i, a in enumerate(ranked):
            for b in ranked[i + 1 :]:
                rows = np.r_[a.rows, b.rows]
                V, score = self.information[np.ix_(rows, rows)], self.total[rows]
                _, drop, _ = predicted_drop(np.concatenate([a.limits, b.limits]), V, score)
                if found is None or drop > found[2]:
                    found = (a, b, drop)
        return found

    def best(self) -> list[Scored]:
        """Each effect at its best grid point, largest predicted drop first."""
        top: dict[str, Scored] = {}
        for s in self.scored:
            # where a bound leaves nothing at any point, the one that shows the effect best
            if s.id not in top or (s.drop, s.unbounded) > (top[s.id].drop, top[s.id].unbounded):
                top[s.id] = s
        return sorted(top.values(), key=lambda s: -s.drop)


def screen(
    fit: Fit,
    setting: PreparedCampaign,
    skip: Sequence[str] = (),
    states: bool = True,
    learned: bool = False,
) -> Screen:
    """Scores every effect that applies and is not in the fit already.

    Args:
        fit: a fit at its optimum.
        setting: the campaign.
        skip: ids to leave out (those in the fit).
        states: whether effects with states of their own are looked at.
        learned: whether laws are, those that have a support.
    """
    missing: dict[str, str] = {}
    every: list[Variant] = []
    effects = [e for e in setting.layout.effects if not isinstance(e, AnyLaw)]
    if learned:
        effects += [law for id, law in laws().items() if id in setting.supports]
    for effect in effects:
        reason = why_not(effect, setting)
        if effect.id in skip or (effect.n_states and not states):
            continue
        if reason:
            if not isinstance(effect, Law):
                missing[effect.id] = reason
        else:
            every += variants(effect, setting)
    base = [u for u, b in zip(fit.unknowns, fit.at_bound, strict=True) if not b]
    count, stacked = _stacked(every)
    block, steps = blocks_of(fit, setting), coarse_steps(setting)
    first = np.unique(block, return_index=True)[1]
    told = _Told(len(first), fit, keep=bool(steps.any()))
    for which, part in parts(fit, sum(len(layer.slots) for layer in stacked) + len(base)):
        told.add(which, part, *_columns(part, setting, base, count, stacked), block[which])
    to = told.to[first]
    nb = int(to.max(initial=count + len(base) - 1)) + 1 - count  # a calibration's shapes are last
    H, g = gathered(told.H, to, count + nb), gathered(told.g, to, count + nb)
    known = dict(zip(fit.unknowns, fit.normal().prior, strict=True))
    prior = np.array([known[u] for u in base] + [1.0] * (nb - len(base)))
    H[np.arange(count, count + nb), np.arange(count, count + nb)] += prior
    # at the optimum the prior balances the data
    g[count + np.flatnonzero(prior[: len(base)])] = 0.0
    covariance = scaled_inverse(H[count:, count:])
    gain = covariance @ H[count:, :count]
    V = H[:count, :count] - H[:count, count:] @ gain
    V = 0.5 * (V + V.T)
    total = g[:count] - g[count:] @ gain
    by_block = BlockInformation.of_gradients(told.H, to, gain)
    scores = by_block.scores(by_block.own_scores(told.g[:, :, None]))[:, :, 0]
    if nb > len(base):
        by_block = _with_prior(by_block, nb - len(base))
    scored = []
    for variant, rows in (pair for layer in stacked for pair in layer.order):
        Ve, s = V[rows, rows], total[rows]
        limits = _limits(fit, variant)
        known = Ve + prior_information(fit, variant)
        estimate, drop, unbounded = predicted_drop(limits, known, s)
        scored.append(
            Scored(
                variant,
                drop,
                unbounded,
                estimate,
                Ve,
                scores[:, rows],
                -gain[: len(base), rows] @ estimate,
                rows,
                limits,
            )
        )
    rounded = rounding(fit, setting, steps, told.columns, block)
    return Screen(tuple(scored), V, by_block, missing, total, covariance, rounded)


@dataclasses.dataclass(frozen=True)
class _Layer:
    """A linearisation of the screen.

    order: variants and the places of their columns among all; changes: numbers of slots; unknowns:
    of all variants, the first at `begin`; slots: theirs.
    """

    order: tuple[tuple[Variant, slice], ...]
    changes: dict[str, float]
    unknowns: tuple[Unknown, ...]
    begin: int

    @property
    def slots(self) -> tuple[str, ...]:
        return columns(self.unknowns)


def _stacked(every: Sequence[Variant]) -> tuple[int, list[_Layer]]:
    """The number of columns of all variants, and the linearisations that give them."""
    at, stacked = 0, []
    for layer in layers(every):
        begin, order = at, []
        for v in layer:
            order.append((v, slice(at, at + len(v.unknowns))))
            at += len(v.unknowns)
        changes = {slot: x for v in layer for slot, x in v.settings.items()}
        unknowns = tuple(u for v in layer for u in v.unknowns)
        stacked.append(_Layer(tuple(order), changes, unknowns, begin))
    return at, stacked


def _columns(
    part: Fit,
    setting: PreparedCampaign,
    base: Sequence[Unknown],
    count: int,
    stacked: Sequence[_Layer],
) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives (w, m, d) of some windows by slot, and where columns stand among unknowns (w, d).

    Those of effects, then the fit's, then a calibration's.
    """
    lin, values = part.linearisation, part.values
    found, to = [], []
    for layer in stacked:
        seen = part.problem.linearise(values.replace(layer.changes), part.states, layer.slots)
        found.append(seen.slots_jac)
        where = places(layer.unknowns, seen.slots, lin.recording)
        to.append(np.where(where < 0, -1, where + layer.begin))
    where = places(base, columns(base), lin.recording)
    to.append(np.where(where < 0, -1, where + count))
    found.append(lin.by_slot(columns(base)))
    shapes = calibration.columns(setting, part)
    found.append(shapes)
    begin = count + len(base)
    of_shapes = np.arange(begin, begin + shapes.shape[2])
    to.append(np.broadcast_to(of_shapes, (len(lin.r), len(of_shapes))))
    return np.concatenate(found, axis=2), np.concatenate(to, axis=1)


class _Told:
    """Sums over blocks of windows, part by part.

    g (B, d), H (B, d, d): by block; to: (w, d) of each window; columns: (w, m, d) derivatives with
    the states projected out, in single precision, if they are kept.
    """

    def __init__(self, blocks: int, fit: Fit, *, keep: bool):
        self._blocks, self._lin, self._keep = blocks, fit.linearisation, keep
        self.g = self.H = np.zeros((0, 0))
        self.to = np.zeros((0, 0), dtype=int)
        self.columns: np.ndarray | None = None

    def add(
        self, which: np.ndarray, part: Fit, jac: np.ndarray, to: np.ndarray, block: np.ndarray
    ) -> None:
        """Adds some windows: their derivatives, where columns stand, and their blocks."""
        lin, (windows, rows), d = part.linearisation, self._lin.r.shape, jac.shape[2]
        if not self.to.size:
            self.g, self.H = np.zeros((self._blocks, d)), np.zeros((self._blocks, d, d))
            self.to = np.zeros((windows, d), dtype=int)
            self.columns = np.zeros((windows, rows, d), dtype=np.float32) if self._keep else None
        elim = eliminate(lin.r, lin.states_jac, jac)
        np.add.at(self.g, block, elim.g)
        np.add.at(self.H, block, elim.H)
        self.to[which] = to
        if self.columns is not None:
            at = np.ix_(which, rows_of(self._lin, lin.n_samples))
            self.columns[at] = jac + lin.states_jac @ elim.state_gain


def _with_prior(by_block: BlockInformation, shapes: int) -> BlockInformation:
    """The blocks, and one more: what the error of a calibration may do to their sum.

    Args:
        by_block: of the windows. shapes: the calibration's, the last columns of all.
    """
    d = by_block.H.shape[1]
    prior = np.zeros((1, d, d))
    last = np.arange(d - shapes, d)
    prior[0, last, last] = 1.0
    to = by_block.to[:1]
    one = BlockInformation.of_gradients(prior, to, by_block.gain)
    H = np.concatenate([by_block.H, one.H])
    return BlockInformation(H, np.concatenate([by_block.to, to]), by_block.gain)


def _limits(fit: Fit, variant: Variant) -> np.ndarray:
    """Bounds (q, 2) of an effect's amplitudes, as a fit of them has them."""
    specs = [parameter(fit.problem, u) for u in variant.unknowns]
    return np.array([(s.lower, s.upper) for s in specs]).reshape(-1, 2)


def prior_information(fit: Fit, variant: Variant) -> np.ndarray:
    """Returns what is known (q, q) of a law's coefficients before any data: that it is smooth.

    Zero for an effect of the catalogue, whose amplitudes the data alone decide here.
    """
    if not isinstance(variant.effect, Law):
        return np.zeros((len(variant.unknowns), len(variant.unknowns)))
    sd = [WIDE * parameter(fit.problem, u).typical for u in variant.unknowns]
    return np.diag(1.0 / np.square(sd))


def predicted_drop(
    limits: np.ndarray, V: np.ndarray, s: np.ndarray
) -> tuple[np.ndarray, float, float]:
    """Amplitudes (q,) within their bounds, the drop that they promise, and that without bounds.

    Args:
        limits: (q, 2) bounds. V: (q, q) efficient information. s: (q,) efficient score.
    """
    inverse = efficient_inverse(V)
    estimate, unbounded = -inverse @ s, float(s @ inverse @ s)
    low, high = limits.T
    if np.all((estimate >= low) & (estimate <= high)):
        return estimate, unbounded, unbounded
    live = np.diag(inverse) > 0.0  # an amplitude that the data do not know stays at null
    step = bounded_step(s[live], V[np.ix_(live, live)], low[live], high[live], 0.0)
    estimate[:] = 0.0
    estimate[live] = step.du
    return estimate, float(np.clip(step.promise, 0.0, unbounded)), unbounded
