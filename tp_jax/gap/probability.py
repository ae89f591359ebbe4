"""Probabilities of causes, from what their models leave of each group of windows.

At every round of the choice the hypotheses are: nothing more, and each effect that was refitted;
the others enter with what the screen predicts. A hypothesis has the log likelihood of each group
(recordings, or long spans of them), divided by the misfit of the best model, and a charge for its
unknowns (Schwarz' criterion).

If the best model is the rig's, then on a group in which its prediction and another's are d^2 apart
(a sum of squares in units of the noise), the other's sum of squares is the larger by
d^2 +- 2 d. How much more the groups scatter about that is the dispersion: errors that both models
have in common, correlated over a recording, are in it. Log likelihoods are divided by it, and it is
known as well as the groups that tell the two apart are many. So an effect that two recordings speak
for and three against is not certain, however many samples they have, and effects that predict alike
share what there is. Whether a cause predicts what was left out is asked elsewhere (`confirmation`).

Source: overdispersion of quasi-likelihoods: McCullagh, Nelder (1989), Generalized Linear Models,
2nd ed., sections 4.5 and 9.2; likelihoods to a power for models that are not the truth: Holmes,
Walker (2017), Biometrika 104, 497-503.
"""

import dataclasses
from collections.abc import Sequence

import numpy as np
from scipy.special import softmax

from tp_jax import _tails as tails
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.gap.backward import Tested
from tp_jax.gap.choice import Choice, Round
from tp_jax.gap.directions import Variant
from tp_jax.gap.left_out import groups
from tp_jax.gap.policy import POLICY, FoldPolicy


@dataclasses.dataclass(frozen=True)
class Densities:
    """Densities of groups under hypotheses.

    Attributes:
        log: (h, G) log likelihoods, up to a constant of each group.
        apart: (h, h, G) squared distances of predictions in units of the noise; NaN of those that
            were not refitted.
        charge: (h,) what is taken off for unknowns.
        prior: (h,) log probabilities before any group is asked, up to a constant.
    """

    log: np.ndarray
    apart: np.ndarray
    charge: np.ndarray
    prior: np.ndarray | None = None


def cause_probabilities(
    choice: Choice, setting: PreparedCampaign, policy: FoldPolicy = POLICY.folds
) -> dict[str, float]:
    """Posterior inclusion of each effect that was looked at.

    Args:
        choice: its rounds. setting: the campaign.
        policy: how recordings are grouped.
    """
    misfit = max(choice.final.fit.chi2_dof, 1.0)
    out: dict[str, float] = {}
    taken = 1.0  # probability of the causes that came before
    for r in choice.rounds:
        found = _of_round(r, setting, misfit, policy)
        for id, p in found.items():
            # an effect may have stood in for a cause, or come in addition to it
            out[id] = min(out.get(id, 0.0) + taken * p, 1.0)
        if r.taken is not None:
            out[r.taken] = found.get(r.taken, 0.0)
            taken *= out[r.taken]
    # together with other causes an effect may look better, or worse, than it did alone
    for cause in choice.causes:
        odds = {t.rival: _odds(t, setting, policy) for t in choice.tested if t.cause == cause}
        if odds:
            out[cause] = 1.0 / (1.0 + sum(odds.values()))
            out |= {id: out[cause] * x for id, x in odds.items() if id not in choice.causes}
    return out


def _odds(t: Tested, setting: PreparedCampaign, policy: FoldPolicy) -> float:
    """Computes the odds of the model that was not kept to the one that was.

    Even odds where the former fits better and predicts what was left out no better: fit and
    prediction then say different things, and neither decides.
    """
    if t.fits_better:
        return 1.0
    effects = (*t.kept.variants, *t.other.variants)
    group = groups(setting, t.kept.fit, policy, any(_by_recording(v) for v in effects))
    scale = max(min(t.kept.fit.chi2_dof, t.other.fit.chi2_dof), 1.0)
    fits = [t.kept.fit, t.other.fit]
    log = np.array([_density(fit, group, scale) for fit in fits])
    unknowns = [sum(len(v.unknowns) for v in r.variants) for r in (t.kept, t.other)]
    charge = _charge(t.kept.fit) * np.array(unknowns)
    kept, other = weights(Densities(log, _apart(fits, group, scale), charge), policy)
    return float(other / max(kept, 1e-12))


def _by_recording(v: Variant) -> bool:
    return any(u.recording is not None for u in v.unknowns)


def _density(fit: Fit, group: np.ndarray, scale: float) -> np.ndarray:
    """Log likelihood of each group, up to a constant."""
    return -0.5 * np.bincount(group, weights=fit.eliminated.cost) / scale


def _charge(fit: Fit) -> float:
    """Charge for each unknown (Schwarz, 1978, Annals of Statistics 6, 461-464)."""
    return 0.5 * float(np.log(max(fit.dof, 2)))


def _apart(fits: Sequence[Fit | None], group: np.ndarray, scale: float) -> np.ndarray:
    """Squared distances (h, h, G) of the predictions of fits on the same windows."""
    out = np.full((len(fits), len(fits), int(group.max()) + 1), np.nan)
    for i, a in enumerate(fits):
        for j, b in enumerate(fits):
            if a is not None and b is not None:
                difference = np.nan_to_num(a.linearisation.r - b.linearisation.r)
                out[i, j] = np.bincount(group, weights=(difference**2).sum(axis=1)) / scale
    return out


def weights(found: Densities, policy: FoldPolicy = POLICY.folds) -> np.ndarray:
    """Posterior weights (h,) of hypotheses.

    Args:
        found: what they leave of the groups.
        policy: how few groups tell nothing, so that all weights are what they were before.
    """
    count = found.log.shape[1]
    prior = np.zeros(len(found.log)) if found.prior is None else found.prior
    if count < policy.fewest:
        return softmax(prior)
    total = found.log.sum(axis=1) - found.charge
    best = int(total.argmax())
    behind = found.log[best] - found.log
    apart = found.apart[best]
    known = np.isfinite(apart).all(axis=1)
    apart = np.where(known[:, None], apart, 0.0)
    distance = apart.sum(axis=1)
    told = distance > 0.0
    spread = ((2.0 * behind - apart) ** 2).sum(axis=1)
    dispersion = np.divide(spread, 4.0 * distance, out=np.ones(len(total)), where=told)
    # groups in which two models hardly differ tell nothing of how far one may trust the others
    count_of = np.divide(distance**2, (apart**2).sum(axis=1), out=np.ones(len(total)), where=told)
    if told.any():
        dispersion[~known] = np.median(dispersion[told])
        count_of[~known] = np.median(count_of[told])
    # What is common to all errors has been divided by already: before any group is asked the
    # dispersion is one. But one group alone agrees with nothing.
    before = np.minimum(policy.agreeing, count_of - 1.0)
    dispersion = (before + count_of * dispersion) / (before + count_of)
    count_of = before + count_of
    # The power is one over the dispersion, which is one at least. The same quantile for all, or
    # hypotheses that predict alike would not share alike.
    dispersion = count_of * np.maximum(dispersion, 1.0)
    quantiles = (np.arange(policy.quantiles) + 0.5) / policy.quantiles
    power = (
        tails.chi_square_quantile(
            quantiles[:, None] * tails.chi_square_below(dispersion, count_of), count_of
        )
        / dispersion
    )
    return softmax(power * (total - total[best]) + prior, axis=1).mean(axis=0)


def _of_round(
    r: Round, setting: PreparedCampaign, misfit: float, policy: FoldPolicy
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
    lowest = min([f.cost for f in r.refits.values()], default=0.0)
    rows, names, unknowns = [base], [""], [0]
    fits: list[Fit | None] = [r.searched]
    for s in best:
        if s.id in refitted:
            rows.append(refitted[s.id])
        else:
            # beyond the best refit a linear prediction promises what nobody can keep
            drop = min(s.drop, max(r.searched.cost - lowest, 0.0)) if refitted else s.drop
            rows.append(base + share * 0.5 * drop / scale)
        names.append(s.id)
        fits.append(r.refits[s.id].fit if s.id in refitted else None)
        unknowns.append(len(s.variant.unknowns))
    charge = _charge(r.searched) * np.array(unknowns)
    # that there is nothing more is as likely as all effects together
    prior = np.where(np.arange(len(rows)) > 0, -np.log(len(best)), 0.0)
    found = weights(Densities(np.array(rows), _apart(fits, group, scale), charge, prior), policy)
    return dict(zip(names[1:], found[1:].tolist(), strict=True))
