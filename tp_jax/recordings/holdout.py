"""Choice of the data that are never fitted, where a campaign does not say."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tp_jax.recordings.campaign import Campaign
from tp_jax.recordings.noise import noise_level
from tp_jax.recordings.recording import Recording

FITTED_SHARE = 0.7
"""Fitted share of a recording cut in two, where there are too few to hold out a whole one."""

_AT_REST = 10.0
"""Noise levels around its final angle within which a pendulum counts as at rest."""


def hold_out(campaign: Campaign, instead: int | None = None) -> Campaign:
    """A campaign with held-out recordings: itself where some are marked, else one is chosen.

    Args:
        campaign: see `load_campaign`.
        instead: number of the recording to hold out; None: chosen as follows.

    From three recordings on, a whole one is held out: of three or more forced ones that at three
    quarters of the order of frequency, so that it is predicted mostly between fitted frequencies;
    else the last forced one, or, where that would leave no forced one to fit, the last decay. Of
    one or two recordings the longest is cut, and the last 30 % of the time it moves is held out.

    The choice depends on nothing but the campaign: it is the same every time.
    """
    if campaign.held_out:
        return campaign
    recordings = campaign.recordings
    if len(recordings) < 3:
        return replace(campaign, recordings=_cut(recordings))
    chosen = _whole(recordings) if instead is None else recordings[instead]
    return replace(
        campaign,
        recordings=tuple(
            replace(each, held_out=True) if each is chosen else each for each in recordings
        ),
    )


def _whole(recordings: Sequence[Recording]) -> Recording:
    forced = [each for each in recordings if each.forced]
    decays = [each for each in recordings if not each.forced]
    if len(forced) >= 3:
        # A measured drive need not have a frequency: those last, in the campaign's order.
        forced.sort(key=lambda each: np.inf if each.omega is None else each.omega)
        return forced[3 * len(forced) // 4]
    if len(forced) == 2 or not decays:
        return forced[-1]
    return decays[-1]


def _cut(recordings: Sequence[Recording]) -> tuple[Recording, ...]:
    longest = max(recordings, key=lambda each: each.duration)
    t = longest.t
    over = longest.drift_over or (float(t[0]), float(t[-1]))
    until = t[0] + FITTED_SHARE * (_end_of_motion(longest) - t[0])
    i = int(np.clip(np.searchsorted(t, until), 1, t.size - 1))
    at = float(0.5 * (t[i - 1] + t[i]))  # no sample is in both parts
    parts = (
        replace(longest.cut(float(t[0]), at), drift_over=over),
        replace(longest.cut(at, float(t[-1])), drift_over=over, held_out=True),
    )
    return tuple(part for each in recordings for part in (parts if each is longest else (each,)))


def _end_of_motion(recording: Recording) -> float:
    """Time [s] after which nothing moves; the last sample's where it moves nearly to the end.

    A decay may be over in a tenth of its recording: a pendulum at rest puts no model to the test.
    """
    t = recording.t
    ends = [float(t[0])]
    for values in recording.channels.values():
        rest = np.median(values[-max(recording.n // 10, 1) :])
        moving = np.abs(values - rest) > _AT_REST * noise_level(t, values)
        ends.append(float(t[np.flatnonzero(moving)[-1]]) if moving.any() else float(t[0]))
    end = max(ends)
    nearly_all = end - t[0] > 0.9 * recording.duration
    return float(t[-1]) if nearly_all or end == t[0] else end
