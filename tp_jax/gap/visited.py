"""Values of the laws' arguments that recordings visit, and whether a law is asked beyond them."""

import dataclasses
from collections.abc import Sequence

import numpy as np

from tp_jax.effects import Law, laws
from tp_jax.effects.laws import HALF, MIDDLE
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.gap.directions import Variant
from tp_jax.gap.policy import POLICY
from tp_jax.gap.refit import Refit

MARGIN = 0.02
"""Part of the visited range, on either side: a run that is predicted may go a little further."""

LEAST_RANGE = 1e-6
"""Least range in the argument's unit; over less there is no curve."""


def visited(setting: PreparedCampaign, fit: Fit) -> dict[str, np.ndarray]:
    """The argument of each law at all samples of a fit (N,), by the law's family.

    Args:
        setting: the campaign. fit: its windows and states; effects in it are left out.
    """
    windows = fit.problem.windows
    held = np.arange(fit.linearisation.n_samples) < windows.count[:, None]
    sample = (windows.first[:, None] + np.arange(held.shape[1]))[held]
    recording = np.broadcast_to(windows.recording[:, None], held.shape)[held]
    return _arguments(setting, fit, recording, sample, fit.linearisation.states[held])


def _arguments(
    setting: PreparedCampaign,
    fit: Fit,
    recording: np.ndarray,
    sample: np.ndarray,
    states: np.ndarray,
) -> dict[str, np.ndarray]:
    """The argument of each law (N,), of samples of recordings (N,) in states (N, 4)."""
    t = np.zeros(sample.size)
    pieces = np.zeros((sample.size, 4))
    for r in np.unique(recording):
        mine = recording == r
        prepared = setting.prepared[r]
        t[mine] = prepared.t[sample[mine]]
        if prepared.pieces is not None:
            last = len(prepared.pieces) - 1
            pieces[mine] = prepared.pieces[np.minimum(sample[mine], last)]
    numbers = tuple(fit.values.table[:, recording])
    model = setting.layout.model(numbers, tuple(pieces.T), t, frozenset())
    m = model.motion(t, tuple(states.T))
    out = {}
    for family, law in laws().items():
        if setting.rider or not (law.about_rider or law.uses_phi2):
            out[family] = np.broadcast_to(np.asarray(law.argument.of(m), float), t.shape)
    return out


def inside_of_others(setting: PreparedCampaign, final: Refit) -> int | None:
    """The recording to hold out instead, where a law is asked beyond what it was fitted on.

    A curve says nothing where nothing went, so a run that goes further than all others puts it to
    no test. Of the others the one is taken that is next to it in the order of frequency and goes
    where the rest goes too. None: no law is asked so, or no recording lies within the others.

    Args:
        setting: the campaign. final: the model with the causes.
    """
    asked = [v.effect.id for v in final.variants if isinstance(v.effect, Law)]
    if not asked or len(setting.held_out) != 1 or len(setting.fitted) < 2:
        return None
    (now,) = setting.held_out
    beyond = POLICY.learning.elsewhere
    if _outside(setting, final.fit, asked, now, setting.fitted) <= beyond:
        return None
    for other in in_its_place(setting):
        rest = [*(i for i in setting.fitted if i != other), now]
        if _outside(setting, final.fit, asked, other, rest) <= beyond:
            return other
    return None


def in_its_place(setting: PreparedCampaign) -> list[int]:
    """Recordings that may be held out in place of the one that is, the likest in frequency first.

    A forced run is among them only if another forced one stays fitted.
    """
    (now,) = setting.held_out
    held = setting.recordings[now]

    def order(i: int) -> tuple[bool, float, int]:
        r = setting.recordings[i]
        return r.forced != held.forced, abs((r.omega or 0.0) - (held.omega or 0.0)), i

    forced = [i for i in setting.fitted if setting.recordings[i].forced]
    return [i for i in sorted(setting.fitted, key=order) if forced != [i]]


def _outside(
    setting: PreparedCampaign, fit: Fit, families: Sequence[str], one: int, others: Sequence[int]
) -> float:
    """Part of a recording's samples at which a law's argument lies beyond the others' range.

    By the smoothed recordings: the choice of what is held out may not read its prediction.
    """
    seen = {i: _of_recording(setting, fit, i) for i in (one, *others)}
    share = 0.0
    for family in families:
        x = seen[one][family]
        low = min(seen[i][family].min() for i in others)
        high = max(seen[i][family].max() for i in others)
        margin = MARGIN * (high - low)
        share = max(share, float(((x < low - margin) | (x > high + margin)).mean()))
    return share


def _of_recording(setting: PreparedCampaign, fit: Fit, i: int) -> dict[str, np.ndarray]:
    """The argument of each law at the samples of a smoothed recording."""
    smooth = setting.prepared[i].smooth
    return _arguments(setting, fit, np.full(len(smooth), i), np.arange(len(smooth)), smooth)


def share_outside(setting: PreparedCampaign, fit: Fit, variant: Variant) -> float:
    """Part of a fit's samples at which a law's argument lies beyond the range it was learned on.

    Args:
        setting: the campaign. fit: windows and states, of held-out recordings say.
        variant: the law, with its range.
    """
    shapes = dict(variant.shapes)
    x = visited(setting, fit)[variant.effect.id]
    return float((np.abs(x - shapes[MIDDLE]) > shapes[HALF]).mean())


def with_supports(setting: PreparedCampaign, fit: Fit) -> PreparedCampaign:
    """The campaign with the range of every law that its fitted recordings can tell of."""
    ranges = {}
    for family, x in visited(setting, fit).items():
        sided = laws()[family].argument.sided
        low, high = (0.0 if sided else float(x.min())), float(x.max())
        margin = MARGIN * (high - low)
        low = low if sided else low - margin
        high = high + margin
        if high - low > LEAST_RANGE:
            ranges[family] = (0.5 * (low + high), 0.5 * (high - low))
    return dataclasses.replace(setting, supports=ranges)
