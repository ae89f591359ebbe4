"""Whether every accepted cause is still needed, and whether another would do better in its place.

A cause that was accepted first may have taken what belongs to another that came later, or to one
that only stands out beside it. So after every addition each cause is left out, the others fitted
again, and those effects that look most like it are tried in its place.
"""

import dataclasses
import logging

import numpy as np

from tp_jax.estimation.baseline import Setting
from tp_jax.gap.detectability import cosine
from tp_jax.gap.directions import Variant
from tp_jax.gap.policy import BackwardPolicy
from tp_jax.gap.refit import Refit, refit
from tp_jax.gap.screen import Screen

log = logging.getLogger(__name__)


def pruned(setting: Setting, result: Refit, policy: BackwardPolicy) -> Refit:
    """A refit without the causes that the others have made needless.

    Args:
        setting: the campaign.
        result: with two causes or more.
        policy: thresholds.
    """
    while len(result.variants) > 1:
        trials = [_without(setting, result, v) for v in result.variants]
        rises = [
            (trial.cost - result.cost) / max(result.fit.chi2_dof, 1.0)
            - policy.deviance - policy.per_amplitude * len(v.unknowns)
            for trial, v in zip(trials, result.variants, strict=True)
        ]  # fmt: skip
        least = int(np.argmin(rises))
        if not rises[least] < 0.0:
            break
        log.info("%s is no longer needed", result.variants[least].effect.id)
        result = trials[least]
    return result


def replaced(setting: Setting, result: Refit, seen: Screen, policy: BackwardPolicy) -> Refit:
    """A refit in which a rival stands in the place of a cause where that does better.

    Args:
        setting: the campaign.
        result: with two causes or more.
        seen: the screen of the baseline, which has all effects.
        policy: thresholds.
    """
    scored = {s.id: s for s in seen.best()}
    for v in result.variants[:-1]:  # the last one has just won against its rivals
        if v.effect.id not in scored:
            continue
        likeness = {
            id: cosine(seen, scored[v.effect.id], s)
            for id, s in scored.items()
            if id not in result.ids and s.drop > 0.0
        }
        near = sorted((id for id, c in likeness.items() if c > policy.likeness),
                      key=lambda id: -likeness[id])[: policy.rivals]  # fmt: skip
        for id in near:
            variants = [scored[id].variant if x is v else x for x in result.variants]
            trial = refit(setting, _without(setting, result, v).fit, variants)
            gain = (result.cost - trial.cost) / max(trial.fit.chi2_dof, 1.0)
            more = len(scored[id].variant.unknowns) - len(v.unknowns)
            if trial.fit.converged and gain > policy.deviance + policy.per_amplitude * more:
                log.info("%s in the place of %s", id, v.effect.id)
                return trial
    return result


def _without(setting: Setting, result: Refit, gone: Variant) -> Refit:
    """The same fit without one cause, the others fitted again."""
    rest = [v for v in result.variants if v is not gone]
    values = result.fit.values.replace({u.name: 0.0 for u in gone.unknowns})
    return refit(setting, dataclasses.replace(result.fit, values=values), rest)
