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
from tp_jax.gap.choice import Choice, Round
from tp_jax.gap.crossvalidation import left_out_cost
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
    return out


def _of_round(
    r: Round, setting: Setting, misfit: float, seed: int, policy: FoldPolicy
) -> dict[str, float]:
    best = r.screen.best()
    if not best:
        return {}
    own = any(u.recording is not None for s in best for u in s.variant.unknowns if s.id in r.refits)
    group = groups(setting, r.searched, policy, within=own)
    count = int(group.max()) + 1
    floor = min([f.fit.chi2_dof for f in r.refits.values()], default=misfit)
    scale = max(floor, misfit if not r.refits else 1.0, 1.0)

    def density(cost: np.ndarray) -> np.ndarray:
        total = np.zeros(count)
        np.add.at(total, group, cost)
        return -0.5 * total / scale

    base = density(left_out_cost(r.searched, group))
    samples = np.bincount(group, weights=r.searched.problem.windows.count, minlength=count)
    share = samples / samples.sum()
    penalty = 0.5 * np.log(max(r.searched.dof, 2))
    rows, names = [base], [""]
    lowest = min([f.cost for f in r.refits.values()], default=0.0)
    for s in best:
        if s.id in r.refits:
            rows.append(density(left_out_cost(r.refits[s.id].fit, group)))
        else:
            # beyond the best refit a linear prediction promises what nobody can keep
            drop = min(s.drop, max(r.searched.cost - lowest, 0.0)) if r.refits else s.drop
            rows.append(base + share * (0.5 * drop / scale - penalty * len(s.variant.unknowns)))
        names.append(s.id)
    table = np.array(rows)
    if count < policy.fewest:
        weights = np.full(len(names), 1.0 / len(names))
    else:
        rng = np.random.default_rng(seed)
        # so the variance of a sum is that of the groups, which have their own mean taken off
        weight = rng.dirichlet(np.full(count, (count - 2.0) / count), DRAWS) * count
        weights = softmax(weight @ table.T, axis=1).mean(axis=0)
    return dict(zip(names[1:], weights[1:].tolist(), strict=True))
