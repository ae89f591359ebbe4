"""A rig's scores, of the first screen of its diagnosis."""

from collections.abc import Sequence

import numpy as np

from tp_jax.effects import Law
from tp_jax.estimation.normal_equations import efficient_inverse
from tp_jax.gap.screen import Scored, Screen
from tp_jax.gap.shared.scores import RigScores, ScoredVariant
from tp_jax.gap.structure import dispersions, scores_of_noise
from tp_jax.model.inertia_units import per_inertia


def rig_scores(
    rig: str, seen: Screen, causes: Sequence[str], seed: int, B1_given: bool = True
) -> RigScores:
    """Returns the screen's scores of effects whose amplitudes are the same in all recordings.

    Effects with amplitudes of each recording are left out: what is one recording's is no rig's. So
    are learned laws, whose range is that of the rig's recordings. If the diagnosis names such an
    effect, it is projected out.

    Args:
        rig: its name.
        seen: the screen of the baseline.
        causes: ids that the rig's own diagnosis names.
        seed: of the draws that tell what coarse readings do.
        B1_given: False if the column's inertia is not known, so that torques are per unit of it.
    """
    best = {s.id: s for s in seen.best()}
    named = [best[id] for id in causes if id in best]
    dispersion = dispersions(seen)
    kept = [
        (s, float(x))
        for s, x in zip(seen.scored, dispersion, strict=True)
        if s.variant.unknowns and not _rigs_alone(s)
    ]
    columns = np.array([i for s, _ in kept for i in range(s.rows.start, s.rows.stop)], dtype=int)
    variants, at = [], 0
    for s, x in kept:
        effect = s.variant.effect
        units = [a.unit if B1_given else per_inertia(a.unit) for a in effect.amplitudes]
        amplitudes = tuple(zip((a.name for a in effect.amplitudes), units, strict=True))
        variants.append(
            ScoredVariant(effect.id, effect.location, s.variant.shapes, amplitudes, at, x)
        )
        at += len(amplitudes)
    # rows of the efficient scores of what is kept, of those of all
    follow = np.eye(len(seen.total))[columns]
    apart = np.concatenate([np.zeros(0, int), *(np.r_[s.rows] for s in named if _rigs_alone(s))])
    if apart.size:
        V = seen.information
        gain = V[np.ix_(columns, apart)] @ efficient_inverse(V[np.ix_(apart, apart)])
        follow[:, apart] -= gain
    information = follow @ seen.information @ follow.T
    noise = information
    if seen.rounding is not None:
        drawn = np.concatenate([x.sum(axis=0) for x in scores_of_noise(seen, seed)], axis=1)
        noise = follow @ np.cov(drawn) @ follow.T
    limits = np.concatenate([np.zeros((0, 2)), *(s.limits for s, _ in kept)])
    return RigScores(
        rig,
        tuple(variants),
        follow @ seen.total,
        information,
        noise,
        limits,
        tuple((s.id, s.variant.shapes) for s in named if not _rigs_alone(s)),
    )


def _rigs_alone(scored: Scored) -> bool:
    """True where an effect's amplitudes can be no other rig's."""
    by_recording = any(unknown.recording is not None for unknown in scored.variant.unknowns)
    return by_recording or isinstance(scored.variant.effect, Law)
