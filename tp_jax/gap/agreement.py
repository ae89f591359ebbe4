"""Number of recordings in which a cause improves the fit.

A cause that is in the rig shows wherever the motion calls for it; one that is credited with the
oddity of a single recording improves that one alone.
"""

import numpy as np

from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.gap.choice import Choice
from tp_jax.gap.crossvalidation import left_out_cost
from tp_jax.gap.held_out import HeldOut
from tp_jax.results.diagnosis import Agreement

NOTICED = 4.0
"""Drop of a recording's sum of squares [variances of the noise] that counts: two standard
deviations of one number. Less is as much as noise moves it either way."""


def agreement(
    effect: str, setting: PreparedCampaign, choice: Choice, before: HeldOut, after: HeldOut | None
) -> Agreement | None:
    """Returns what the recordings say of an effect, added by itself to where its refit began.

    Args:
        effect: its id. setting: the campaign. choice: with its refit in the first round.
        before, after: held-out recordings without it and with it; None: not asked.

    Returns:
        None where it was not refitted by itself.
    """
    first = choice.rounds[0]
    if effect not in first.refits:
        return None
    without, with_it = first.searched, first.refits[effect].fit
    drops = by_recording(without, left_out_cost(without) - left_out_cost(with_it))
    if after is not None and before.complete and after.complete:
        drops |= by_recording(before.fit, _costs(before.fit) - _costs(after.fit))
    labels = {setting.recordings[r].label: drop for r, drop in sorted(drops.items())}
    improved = sum(drop > NOTICED for drop in labels.values())
    worse = tuple(label for label, drop in labels.items() if drop < -NOTICED)
    return Agreement(improved, len(labels), worse, labels)


def by_recording(fit: Fit, of_windows: np.ndarray) -> dict[int, float]:
    """Sums over the windows (w,) of each recording, by its index."""
    recording = fit.problem.windows.recording
    return {int(r): float(of_windows[recording == r].sum()) for r in np.unique(recording)}


def _costs(fit: Fit) -> np.ndarray:
    """Sum of squares (w,) of the windows' samples."""
    return (fit.linearisation.r[:, :-4] ** 2).sum(axis=1)
