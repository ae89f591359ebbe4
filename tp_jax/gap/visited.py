"""Values of the laws' arguments that the fitted recordings visit."""

import dataclasses

import numpy as np

from tp_jax.effects import laws
from tp_jax.effects.laws import HALF, MIDDLE
from tp_jax.estimation.baseline import Setting
from tp_jax.estimation.fitted import Fit
from tp_jax.gap.directions import Variant

MARGIN = 0.02
"""Of the visited range, on either side: a run that is predicted may go a little further."""

LEAST_RANGE = 1e-6
"""In the argument's unit; over less there is no curve."""


def visited(setting: Setting, fit: Fit) -> dict[str, np.ndarray]:
    """The argument of each law at all samples of a fit (N,), by the law's family.

    Args:
        setting: the campaign. fit: its windows and states; effects in it are left out.
    """
    windows = fit.problem.windows
    held = np.arange(fit.linearisation.n_samples) < windows.count[:, None]
    sample = (windows.first[:, None] + np.arange(held.shape[1]))[held]
    recording = np.broadcast_to(windows.recording[:, None], held.shape)[held]
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
    m = model.motion(t, tuple(fit.linearisation.states[held].T))
    out = {}
    for family, law in laws().items():
        if setting.rider or not (law.about_rider or law.uses_phi2):
            out[family] = np.broadcast_to(np.asarray(law.argument.of(m), float), t.shape)
    return out


def share_outside(setting: Setting, fit: Fit, variant: Variant) -> float:
    """Part of a fit's samples at which a law's argument lies beyond the range it was learned on.

    Args:
        setting: the campaign. fit: windows and states, of held-out recordings say.
        variant: the law, with its range.
    """
    shapes = dict(variant.shapes)
    x = visited(setting, fit)[variant.effect.id]
    return float((np.abs(x - shapes[MIDDLE]) > shapes[HALF]).mean())


def with_supports(setting: Setting, fit: Fit) -> Setting:
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
