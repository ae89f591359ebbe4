"""Tests if every accepted cause is still needed, and if another would do better in its place.

A cause that was accepted first may have taken what belongs to another that came later, or to one
that only stands out beside it. So after every addition each cause is left out, the others fitted
again, and those that it once won against are tried in its place.
"""

import dataclasses
import logging
from collections.abc import Mapping, Sequence

import numpy as np

from tp_jax.estimation.layout import Values
from tp_jax.estimation.normal_equations import scaled_inverse
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.gap.confirmation import confirm
from tp_jax.gap.directions import Variant
from tp_jax.gap.left_out import groups, left_out
from tp_jax.gap.policy import POLICY, BackwardPolicy
from tp_jax.gap.refit import Refit, refit

log = logging.getLogger(__name__)


def pruned(setting: PreparedCampaign, result: Refit, policy: BackwardPolicy) -> Refit:
    """A refit without the causes that the others have made needless.

    Args:
        setting: the campaign.
        result: with two causes or more.
        policy: thresholds.
    """
    while len(result.variants) > 1:
        rises: dict[int, float] = {}
        trials: dict[int, Refit] = {}
        for i, v in enumerate(result.variants):
            if wald(result, v) > policy.sure * _needed(v, policy):
                continue
            trials[i] = without(setting, result, v)
            if trials[i].fit.converged:
                misfit = max(result.fit.chi2_dof, 1.0)
                rises[i] = (trials[i].cost - result.cost) / misfit - _needed(v, policy)
        least = min(rises, key=lambda i: rises[i], default=None)
        if least is None or rises[least] > 0.0:
            break
        log.info("%s is no longer needed", result.variants[least].effect.id)
        result = trials[least]
    return result


@dataclasses.dataclass(frozen=True)
class Tested:
    """Two models that differ in one cause, on the same windows: the one kept and the other.

    fits_better: whether the other fits clearly better, and was refused because it does not predict
    what was left out better.
    """

    kept: Refit
    other: Refit
    cause: str
    rival: str
    fits_better: bool = False


def replaced(
    setting: PreparedCampaign,
    result: Refit,
    rounds: Sequence[Mapping[str, Refit]],
    policy: BackwardPolicy,
) -> tuple[Refit, list[Tested]]:
    """A refit in which a rival stands in the place of a cause where that does better.

    Args:
        setting: the campaign.
        result: with two causes or more.
        rounds: what was refitted in each round of the choice, by id.
        policy: thresholds.

    Returns:
        The refit, and all pairs that were compared.
    """
    tested: list[Tested] = []
    for v in result.variants[:-1]:  # the last one has just won against its rivals
        for refits in rounds:
            won = refits.get(v.effect.id)
            if won is None:
                continue
            near = [
                r
                for id, r in refits.items()
                if id not in result.ids
                and r.fit.converged
                and r.fit.chi2_dof < policy.near * won.fit.chi2_dof
            ]
            near.sort(key=lambda r: r.cost)
            for rival in near[: policy.rivals]:
                trial = _instead(setting, result, v, rival)
                if not trial.fit.converged:
                    continue
                gain = (result.cost - trial.cost) / max(trial.fit.chi2_dof, 1.0)
                new = trial.variants[result.variants.index(v)]
                more = len(new.unknowns) - len(v.unknowns)
                better = gain > policy.deviance + policy.per_amplitude * more
                if better and _predicts_better(setting, result, trial):
                    log.info("%s in the place of %s", new.effect.id, v.effect.id)
                    tested.append(Tested(trial, result, new.effect.id, v.effect.id))
                    return trial, tested
                tested.append(Tested(result, trial, v.effect.id, new.effect.id, better))
            break
    return result, tested


def _predicts_better(setting: PreparedCampaign, old: Refit, new: Refit) -> bool:
    """True where groups left out are predicted better, in short windows and in long ones."""
    effects = (*old.variants, *new.variants)
    within = any(u.recording is not None for v in effects for u in v.unknowns)
    group = groups(setting, old.fit, POLICY.folds, within)
    before, after = (left_out(setting, r, group, POLICY.confirm) for r in (old, new))
    found = confirm(before, after, new.fit.chi2_dof, 0, POLICY.confirm)
    return found.confirmed and found.error_ratio <= 1.0


def wald(result: Refit, variant: Variant) -> float:
    """Rise of the sum of squares over the misfit if a cause's amplitudes were zero, linearised.

    Its shape constants are held: without an amplitude none of them can take its place, however
    much the two trade off where it is large.
    """
    fit = result.fit
    shapes = {variant.effect.qualified(s.name) for s in variant.effect.shapes}
    asked = [i for i, u in enumerate(fit.unknowns) if u.name not in shapes]
    unknowns = [fit.unknowns[i] for i in asked]
    mine = [unknowns.index(u) for u in variant.unknowns if u in unknowns]
    x = fit.values.pick([unknowns[i] for i in mine])
    covariance = scaled_inverse(fit.normal().part(asked).information)[np.ix_(mine, mine)]
    return float(x @ scaled_inverse(covariance) @ x) / max(fit.chi2_dof, 1.0)


def _needed(variant: Variant, policy: BackwardPolicy) -> float:
    return policy.deviance + policy.per_amplitude * len(variant.unknowns)


def without(setting: PreparedCampaign, result: Refit, gone: Variant) -> Refit:
    """The same fit without one cause, the others fitted again."""
    rest = [v for v in result.variants if v is not gone]
    values = result.fit.values.replace({u.name: 0.0 for u in gone.unknowns})
    return refit(setting, dataclasses.replace(result.fit, values=values), rest)


def _instead(setting: PreparedCampaign, result: Refit, gone: Variant, rival: Refit) -> Refit:
    """The same causes with a rival in the place of one, from where the rival was fitted before.

    From where the cause stood there may be no way: what a spring had, gravity may have now.
    """
    new = rival.variants[-1]
    variants = [new if x is gone else x for x in result.variants]
    # causes of the rival's round that have been replaced since are not in the model any more
    others = [u.name for x in rival.variants if x is not new for u in x.unknowns]
    values: Values = rival.fit.values.replace(dict.fromkeys(others, 0.0))
    for v in result.variants:
        if v is not gone:
            names = [u.name for u in v.unknowns]
            rows = {n: result.fit.values.table[values.layout.index[n]] for n in names}
            values = values.replace(rows)
    return refit(setting, dataclasses.replace(result.fit, values=values), variants)
