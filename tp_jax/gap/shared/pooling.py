"""One effect over all rigs: efficient scores and information are added.

Rigs are independent, so the scores s_i and information V_i of an effect's amplitudes add up, each
divided by the dispersion phi_i of that rig: a rig that is misfit for reasons of its own counts for
less. With S and V the sums, the amplitudes of all rigs are -V^-1 S and the predicted reduction is
S' V^-1 S, in units of the noise's variance. Two kinds of other effects are projected out before:
in each rig those that are its own, with amplitudes of that rig; and over all rigs together those
that are the kind's, with one set of amplitudes for all.
"""

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np

from tp_jax import _tails as tails
from tp_jax.estimation.normal_equations import efficient_inverse
from tp_jax.gap.policy import POLICY
from tp_jax.gap.screen import predicted_drop
from tp_jax.gap.shared.scores import Key, RigScores, ScoredVariant

NORMAL = 1.96
"""Standard errors of half a 95 % interval."""


@dataclasses.dataclass(frozen=True)
class Part:
    """Score and information of one rig for an effect and the kind's others together.

    Attributes:
        rig: its place in the fleet.
        score: (Q,) the effect's amplitudes first. information: (Q, Q).
        rows: (Q, E) that make the score of the rig's.
        dispersion: by which both are to be divided, 1 at least.
    """

    rig: int
    score: np.ndarray
    information: np.ndarray
    rows: np.ndarray
    dispersion: float


@dataclasses.dataclass(frozen=True)
class Pooled:
    """An effect over all rigs that can show it.

    Attributes:
        key: the effect and its shape constants. parts: what each rig says.
        follow: of each part, (q, E) rows that make its share of the pooled score.
        score: (q,) pooled; information: (q, q); limits: (q, 2) bounds that hold on all rigs.
        estimate: (q,) amplitudes within the bounds. drop: predicted reduction, in variances of the
            noise.
        others: (Q - q,) amplitudes of the kind's other effects, the effect's own free.
    """

    key: Key
    parts: tuple[Part, ...]
    follow: tuple[np.ndarray, ...]
    score: np.ndarray
    information: np.ndarray
    limits: np.ndarray
    estimate: np.ndarray
    drop: float
    others: np.ndarray

    @property
    def statistic(self) -> float:
        """-log of the probability of such a reduction by chance, of this effect alone."""
        return float(-tails.log_chi_square(self.drop, len(self.score)))

    @property
    def standard_errors(self) -> np.ndarray:
        """(q,) of the amplitudes, if they are the same on all rigs; inf where nothing is known."""
        variance = np.diag(efficient_inverse(self.information))
        return np.sqrt(np.where(variance > 0.0, variance, np.inf))


@dataclasses.dataclass(frozen=True)
class Agreement:
    """Agreement of the rigs on the amplitudes.

    Attributes:
        q, dof, p: Cochran's Q: sum of squares of the rigs' scores once the pooled amplitudes are
            in, its degrees of freedom, and the probability of more by chance.
        spread: standard deviation of the rigs' amplitudes about the pooled ones, over those, beyond
            what their errors explain (DerSimonian and Laird 1986, Control. Clin. Trials 7:177).
        by_rig: amplitudes of each rig over the pooled ones. p_by_rig: that a rig alone shows none.
    """

    q: float
    dof: int
    p: float
    spread: float
    by_rig: tuple[float, ...]
    p_by_rig: tuple[float, ...]


def pool(
    rigs: Sequence[RigScores],
    key: Key,
    kinds: Sequence[Key] = (),
    owns: Sequence[Key] = (),
    without: int | None = None,
) -> Pooled:
    """An effect over all rigs.

    Args:
        rigs: of the fleet.
        key: the effect and its shape constants.
        kinds: effects of the kind's that are projected out with one set of amplitudes for all.
        owns: effects that are projected out with amplitudes of each rig, in addition to its
            own causes.
        without: a rig that is left out.
    """
    sizes = {each: _size(rigs, each) for each in (key, *kinds)}
    parts = [
        part_of(rig, i, sizes, owns)
        for i, rig in enumerate(rigs)
        if i != without and key in rig.by_key
    ]
    return together(key, parts, _limits([rigs[part.rig] for part in parts], key))


def part_of(rig: RigScores, place: int, sizes: Mapping[Key, int], owns: Sequence[Key]) -> Part:
    """Returns what a rig says of some effects; those of its own are projected out.

    An effect that is asked for is not projected out, even if the rig's own diagnosis names it, nor
    is a cause of its own that resembles it on this rig (`SharedPolicy.alike`). Of an effect that
    does not apply to the rig it says nothing: score and information are zero.

    Args:
        rig: its scores. place: of the rig in the fleet.
        sizes: effects that are asked for, with their numbers of amplitudes; the rig has one at
            least.
        owns: effects that are projected out in addition to the rig's own causes.
    """
    known = rig.by_key
    n = len(rig.score)
    asked = {effect for effect, _ in sizes}
    first = next(known[key] for key in sizes if key in known)
    others = [*(key for key in rig.own if not _alike(rig, first, known.get(key))), *owns]
    apart = [
        known[key].columns for key in dict.fromkeys(others) if key in known and key[0] not in asked
    ]
    rows = np.concatenate(
        [
            np.eye(n)[known[key].columns] if key in known else np.zeros((size, n))
            for key, size in sizes.items()
        ]
    )
    if apart:
        columns = np.concatenate([np.r_[each] for each in apart])
        V = rig.information
        gain = rows @ V[:, columns] @ efficient_inverse(V[np.ix_(columns, columns)])
        rows[:, columns] -= gain
    return Part(
        place, rows @ rig.score, rows @ rig.information @ rows.T, rows, max(first.dispersion, 1.0)
    )


def _alike(rig: RigScores, one: ScoredVariant, own: ScoredVariant | None) -> bool:
    """True where a rig's own cause may be the effect under another name."""
    if own is None:
        return False
    a, b, V = one.columns, own.columns, rig.information
    return canonical(V[a, a], V[a, b], V[b, b]) > POLICY.shared.alike


def together(key: Key, parts: Sequence[Part], limits: np.ndarray) -> Pooled:
    """The parts of all rigs added, the kind's others projected out.

    Args:
        key: of the effect. parts: what each rig says. limits: (q, 2) bounds of the amplitudes.
    """
    q = len(limits)
    V = np.sum([part.information / part.dispersion for part in parts], axis=0)
    S = np.sum([part.score / part.dispersion for part in parts], axis=0)
    gain = V[:q, q:] @ efficient_inverse(V[q:, q:])
    follow = tuple((part.rows[:q] - gain @ part.rows[q:]) / part.dispersion for part in parts)
    score, information = S[:q] - gain @ S[q:], V[:q, :q] - gain @ V[q:, :q]
    estimate, drop, _ = predicted_drop(limits, information, score)
    others = -efficient_inverse(V[q:, q:]) @ (S[q:] + V[q:, :q] @ estimate)
    return Pooled(key, tuple(parts), follow, score, information, limits, estimate, drop, others)


def _limits(rigs: Sequence[RigScores], key: Key) -> np.ndarray:
    every = np.stack([rig.limits[rig.by_key[key].columns] for rig in rigs])
    return np.stack([every[:, :, 0].max(axis=0), every[:, :, 1].min(axis=0)], axis=1)


def agreement(pooled: Pooled) -> Agreement:
    """Tests whether the rigs agree on a pooled effect's amplitudes, with the kind's others held."""
    q, a = len(pooled.score), pooled.estimate
    total, dof = 0.0, -np.linalg.matrix_rank(efficient_inverse(pooled.information), hermitian=True)
    factors, weights, alone = [], [], []
    for part in pooled.parts:
        score = (part.score[:q] + part.information[:q, q:] @ pooled.others) / part.dispersion
        V = part.information[:q, :q] / part.dispersion
        inverse = efficient_inverse(V)
        rank = np.linalg.matrix_rank(inverse, hermitian=True)
        left = score + V @ a
        total += float(left @ inverse @ left)
        dof += rank
        weights.append(float(a @ V @ a))
        factors.append(-float(a @ score) / weights[-1] if weights[-1] > 0.0 else 0.0)
        alone.append(float(np.exp(tails.log_chi_square(score @ inverse @ score, max(rank, 1)))))
    p = float(np.exp(tails.log_chi_square(total, dof))) if dof > 0 else 1.0
    w, c = np.array(weights), np.array(factors)
    scatter = float(w @ (c - 1.0) ** 2) - (len(c) - 1)
    usual = w.sum() - (w**2).sum() / max(w.sum(), 1e-300)
    spread = float(np.sqrt(max(scatter, 0.0) / usual)) if usual > 0.0 else 0.0
    return Agreement(total, int(dof), p, spread, tuple(factors), tuple(alone))


def cosine(
    rigs: Sequence[RigScores], a: Key, b: Key, kinds: Sequence[Key] = (), owns: Sequence[Key] = ()
) -> float:
    """Largest |cos| between the projected directions of two effects at the pooled information.

    Args:
        rigs: of the fleet; those that show only one of the effects tell them apart.
        a, b: the effects. kinds, owns: as in `pool`.
    """
    sizes = {key: _size(rigs, key) for key in (a, b, *kinds)}
    parts = [
        part_of(rig, i, sizes, owns)
        for i, rig in enumerate(rigs)
        if a in rig.by_key or b in rig.by_key
    ]
    V = np.sum([part.information / part.dispersion for part in parts], axis=0)
    q, n = sizes[a], sizes[a] + sizes[b]
    V = V[:n, :n] - V[:n, n:] @ efficient_inverse(V[n:, n:]) @ V[n:, :n]
    return canonical(V[:q, :q], V[:q, q:], V[q:, q:])


def canonical(one: np.ndarray, across: np.ndarray, other: np.ndarray) -> float:
    """Largest canonical correlation, from the blocks of an information matrix."""
    cross = _root(one) @ across @ _root(other)
    return float(np.clip(np.linalg.svd(cross, compute_uv=False).max(initial=0.0), 0.0, 1.0))


def _size(rigs: Sequence[RigScores], key: Key) -> int:
    """Amplitudes of an effect, on the first rig that has it."""
    return next((len(rig.by_key[key].amplitudes) for rig in rigs if key in rig.by_key), 0)


def _root(V: np.ndarray) -> np.ndarray:
    """Root of the inverse information."""
    value, vector = np.linalg.eigh(efficient_inverse(V))
    return vector * np.sqrt(np.maximum(value, 0.0)) @ vector.T
