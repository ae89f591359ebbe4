"""Causes under the noise that they leave, and the drives that they show: chosen, both looked at
again, chosen anew."""

import dataclasses
from collections.abc import Callable

import numpy as np

from tp_jax.estimation.drive_errors import with_drives_of_angles
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.estimation.residual_noise import with_residual_noise
from tp_jax.estimation.schedule import refitted
from tp_jax.gap.choice import Choice
from tp_jax.gap.learned import Trials, choose_or_learn, learn
from tp_jax.gap.policy import POLICY, NoisePolicy
from tp_jax.gap.refit import Refit, refit_longer_windows, with_shapes


def choose_under_noise(
    setting: PreparedCampaign,
    baseline: Fit,
    seed: int,
    progress: Callable[[str, float | None], None],
    gap: bool = False,
) -> tuple[PreparedCampaign, Choice]:
    """The causes, and the campaign with its noise as it shows once they are in.

    Where the data alone do not say what colour the noise has, what the baseline leaves does, and
    some of that may be gap. What the causes leave says it better; then all is judged anew. Laws
    in addition to causes, which take the longest, are asked for once the noise is known so.

    Args:
        setting, baseline, seed, progress: see `choose`.
        gap: whether there is known to be one: what the baseline leaves is then not asked for noise.
    """
    setting, baseline = with_drives_of_angles(setting, baseline)
    asked = baseline.chi2_dof < POLICY.noise.below and not gap
    if asked:
        setting, baseline = with_noise_of(setting, baseline, baseline)
    trials: Trials = []
    choice = choose_or_learn(setting, baseline, seed, progress, trials=trials)
    if all(not r.forced for r in setting.recordings):
        looked = _looked_longer(setting, baseline, choice, seed, progress, trials)
        setting, baseline, choice = looked
    known = None
    # What is left of a large gap is gap still, however slow it looks.
    told = choice.final.fit.chi2_dof < POLICY.noise.below
    if told and (choice.final.ids or not asked):
        shown, read = choice.final.fit, setting
        if choice.final.ids:
            # without the causes some drives had further to go than noise moves them
            bounds = with_shapes(setting, choice.final)[1]
            setting, shown = with_drives_of_angles(setting, shown, bounds, kinks=True)
        if setting is not read or not alike(setting, with_residual_noise(setting, shown)):
            known, looks = choice.final, choice.looks
            if setting is not read:
                baseline = refitted(setting, baseline)
            setting, baseline = with_noise_of(setting, shown, baseline)
            choice = choose_or_learn(setting, baseline, seed, progress, known, trials)
            choice = dataclasses.replace(choice, looks=looks)
    return setting, learn(setting, choice, seed, progress, known, trials)


def alike(
    one: PreparedCampaign, other: PreparedCampaign, policy: NoisePolicy = POLICY.noise
) -> bool:
    """True where a campaign has about the same noise in both."""
    ratio = np.abs(np.log(one.levels / other.levels))[one.fitted]
    if ratio.max() > policy.level:
        return False
    pairs = [
        pair
        for i in one.fitted
        for pair in zip(one.prepared[i].colour, other.prepared[i].colour, strict=True)
    ]
    return all(
        abs(a.neighbours - b.neighbours) <= policy.correlation
        and max(a.slow, b.slow) <= policy.slow * min(a.slow, b.slow)
        for a, b in pairs
    )


def _looked_longer(
    setting: PreparedCampaign,
    baseline: Fit,
    choice: Choice,
    seed: int,
    progress: Callable[[str, float | None], None],
    trials: Trials,
) -> tuple[PreparedCampaign, Fit, Choice]:
    """Decays over longer windows, where shorter ones show no cause.

    A drag that takes a hundredth of the energy in a period is hidden by the noise of a window of
    one and a half, and plain after ten. The parameters are the better known for it, too.
    """
    policy = POLICY.horizon
    for look in range(policy.looks):
        if choice.final.ids or baseline.chi2_dof >= policy.below:
            break
        longer = refit_longer_windows(setting, Refit(baseline, ()), policy.factor).fit
        if longer is baseline:
            break
        progress("longer windows", None)
        setting, baseline = with_noise_of(setting, longer, longer)
        choice = choose_or_learn(setting, baseline, seed, progress, trials=trials)
        choice = dataclasses.replace(choice, looks=look + 2)
    return setting, baseline, choice


def with_noise_of(
    setting: PreparedCampaign, shown: Fit, baseline: Fit
) -> tuple[PreparedCampaign, Fit]:
    """The campaign with the noise that a fit shows, and the baseline under it.

    A fit under white noise absorbs some of a colour where its windows start at rest, so that of the
    baseline is looked at once more under what it showed first.
    """
    own = shown is baseline
    for _ in range(2 if own else 1):
        found = with_residual_noise(setting, shown)
        if found is setting:
            break
        setting, baseline = found, refitted(found, baseline)
        shown = baseline
    return setting, baseline
