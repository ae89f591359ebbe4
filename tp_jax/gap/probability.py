"""Probabilities of causes, from what their models predict of groups that were left out.

At every round of the choice the hypotheses are: nothing more, and each effect that was refitted;
the others enter with what the screen predicts, charged for their unknowns. A hypothesis has the
log predictive density of each group under a fit without it, divided by the misfit of the best
model; its weight is the mean of its share over groups drawn anew with replacement (Bayesian
bootstrap). So an effect that two recordings speak for and three against is not certain, however
many samples they have, and effects that predict alike share what there is.

Source: Yao, Vehtari, Simpson, Gelman (2018), Bayesian Analysis 13, 917-1007 (pseudo-BMA+).
"""

import numpy as np
from scipy.special import softmax

from tp_jax.estimation.baseline import Setting
from tp_jax.estimation.least_squares import Fit
from tp_jax.gap.backward import Tested
from tp_jax.gap.choice import Choice, Round
from tp_jax.gap.crossvalidation import left_out_cost
from tp_jax.gap.directions import Variant
from tp_jax.gap.left_out import groups
from tp_jax.gap.policy import POLICY, FoldPolicy

DRAWS = 2000


def cause_probabilities(
    choice: Choice, setting: Setting, seed: int = 0, policy: FoldPolicy = POLICY.folds
) -> dict[str, float]:
    """Posterior inclusion of each effect that was looked at.

    Args:
        choice: its rounds. setting: the campaign. seed: of the bootstrap.
        policy: how recordings are grouped.
    """
    misfit = max(choice.final.fit.chi2_dof, 1.0)
    out: dict[str, float] = {}
    for r in choice.rounds:
        for id, p in _of_round(r, setting, misfit, seed, policy).items():
            out[id] = max(out.get(id, 0.0), p)
    # beside other causes an effect may look better, or worse, than it did alone
    for cause in choice.causes:
        odds = {t.rival: _odds(t, setting, seed, policy) for t in choice.tested if t.cause == cause}
        if odds:
            out[cause] = 1.0 / (1.0 + sum(odds.values()))
            out |= {id: out[cause] * x for id, x in odds.items() if id not in choice.causes}
    return out


def _odds(t: Tested, setting: Setting, seed: int, policy: FoldPolicy) -> float:
    """Of the model that was not kept to the one that was."""
    effects = (*t.kept.variants, *t.other.variants)
    group = groups(setting, t.kept.fit, policy, any(_by_recording(v) for v in effects))
    scale = max(min(t.kept.fit.chi2_dof, t.other.fit.chi2_dof), 1.0)
    table = np.array([_density(r.fit, group, scale) for r in (t.kept, t.other)])
    kept, other = _weights(table, seed, policy)
    return float(other / max(kept, 1e-12))


def _by_recording(v: Variant) -> bool:
    return any(u.recording is not None for u in v.unknowns)


def _density(fit: Fit, group: np.ndarray, scale: float) -> np.ndarray:
    """Log predictive density of each group without it, up to a constant."""
    total = np.zeros(int(group.max()) + 1)
    np.add.at(total, group, left_out_cost(fit, group))
    return -0.5 * total / scale


def _weights(table: np.ndarray, seed: int, policy: FoldPolicy) -> np.ndarray:
    """Weights of hypotheses from their log densities (hypotheses, groups)."""
    count = table.shape[1]
    if count < policy.fewest:
        return np.full(len(table), 1.0 / len(table))
    rng = np.random.default_rng(seed)
    # so the variance of a sum is that of the groups, which have their own mean taken off
    weight = rng.dirichlet(np.full(count, (count - 2.0) / count), DRAWS) * count
    return softmax(weight @ table.T, axis=1).mean(axis=0)


def _of_round(
    r: Round, setting: Setting, misfit: float, seed: int, policy: FoldPolicy
) -> dict[str, float]:
    best = r.screen.best()
    if not best:
        return {}
    own = any(_by_recording(s.variant) for s in best if s.id in r.refits)
    group = groups(setting, r.searched, policy, within=own)
    count = int(group.max()) + 1
    floor = min([f.fit.chi2_dof for f in r.refits.values()], default=misfit)
    scale = max(floor, misfit if not r.refits else 1.0, 1.0)
    base = _density(r.searched, group, scale)
    refitted = {id: _density(f.fit, group, scale) for id, f in r.refits.items()}
    # What is only predicted is expected where the best refit found it: no group can gain more than
    # it has to.
    samples = np.bincount(group, weights=r.searched.problem.windows.count, minlength=count)
    best_gain = max((d - base for d in refitted.values()), key=np.sum, default=samples)
    share = np.maximum(best_gain, 0.0) / max(float(np.maximum(best_gain, 0.0).sum()), 1e-300)
    penalty = 0.5 * np.log(max(r.searched.dof, 2))
    lowest = min([f.cost for f in r.refits.values()], default=0.0)
    rows, names = [base], [""]
    for s in best:
        if s.id in refitted:
            rows.append(refitted[s.id])
        else:
            # beyond the best refit a linear prediction promises what nobody can keep
            drop = min(s.drop, max(r.searched.cost - lowest, 0.0)) if refitted else s.drop
            rows.append(base + share * (0.5 * drop / scale - penalty * len(s.variant.unknowns)))
        names.append(s.id)
    weights = _weights(np.array(rows), seed, policy)
    return dict(zip(names[1:], weights[1:].tolist(), strict=True))
