"""Shrink of the gap on each recording, by models that were not fitted to it.

One held-out recording tells of one motion. Every fitted one is predicted too, by both models as
they would be fitted without it: the unknowns move by one Newton step (`crossvalidation.moves`), and
the windows' states are estimated anew. Source: Stone (1974), J. R. Statist. Soc. B 36:111.
"""

import dataclasses

from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.layout import Values
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.gap.choice import Choice
from tp_jax.gap.crossvalidation import moves
from tp_jax.gap.held_out import evaluate, shrink


def shrink_by_recording(
    setting: PreparedCampaign, choice: Choice, horizon: float, seed: int
) -> dict[str, float | None]:
    """Label of each recording -> part of its removable gap that is gone.

    None where a recording shows no gap beyond chance. A campaign with a single fitted recording has
    none that could be left out.

    Args:
        setting: the campaign. choice: with the model that is offered. horizon: of windows [s].
        seed: as of `shrink`.
    """
    final = choice.final
    models = [(choice.baseline, []), (final.fit, [v.effect for v in final.variants])]
    asked = setting.held_out if len(setting.fitted) < 2 else range(len(setting.recordings))
    out = {}
    for i in asked:
        before, after = (
            evaluate(setting, _without(fit, i), horizon, effects, which=[i])
            for fit, effects in models
        )
        out[setting.recordings[i].label] = shrink(_held_out(setting, i), before, after, seed).value
    return out


def _held_out(setting: PreparedCampaign, i: int) -> PreparedCampaign:
    """The campaign with one recording held out and no other: its noise is the floor."""
    recordings = tuple(
        dataclasses.replace(r, held_out=j == i) for j, r in enumerate(setting.recordings)
    )
    return dataclasses.replace(setting, recordings=recordings)


def _without(fit: Fit, i: int) -> Values:
    """The numbers of a fit as they would be without one of its recordings."""
    fold = (fit.problem.windows.recording == i).astype(int)
    return moves(fit, fold).values(fit, 1) if fold.any() else fit.values
