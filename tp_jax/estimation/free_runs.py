"""The paper's objective (17) for many sets of numbers at once: all their runs in one batch."""

import dataclasses
from collections.abc import Sequence

import numpy as np

from tp_jax.estimation.baseline import Setting
from tp_jax.estimation.layout import Layout, Values
from tp_jax.estimation.windows import Prepared
from tp_jax.model.drive import PiecewiseCubicDrive
from tp_jax.recordings import Recording
from tp_jax.recordings.gaps import stretches
from tp_jax.simulation.sweep import sweep

AT_REST = 4.0  # standard errors: a first reading within them of rest is rest
SLOW = 0.05  # of the largest rate: a decay that begins no faster was let go
FIRST_SAMPLES = 4  # that the state at the beginning is read from
POWERS = (0, 2)  # of time, in a motion that begins at rest
STEPS = 60  # per sample: numbers that need more are too stiff to be anybody's


class FreeRuns:
    """y = mean over recordings of (17): half the sum of the channels' mean squared errors.

    With one channel, its mean square. Forced runs start from rest and decays from where they were
    let go, unless the first readings say otherwise.
    """

    def __init__(self, setting: Setting):
        self.setting = setting
        self.layout = Layout(setting.campaign.model, ())
        self.states = {
            r: first_state(setting.prepared[r], setting.recordings[r]) for r in setting.fitted
        }
        self.groups = _groups(setting)

    def __call__(self, many: Sequence[Values]) -> np.ndarray:
        """y (m,) [rad^2]; infinite where a run could not be integrated."""
        total = np.zeros(len(many))
        for group in self.groups:
            total += self._group(many, group)
        total /= len(self.setting.fitted)
        return np.where(np.isfinite(total), total, np.inf)

    def _group(self, many: Sequence[Values], group: list[int]) -> np.ndarray:
        """Sum of (17) over recordings with the same times."""
        first = self.setting.prepared[group[0]]
        slots = len(self.layout.parameters)
        p = np.concatenate([v.table[:slots][:, group] for v in many], axis=1)
        model = self.layout.model(tuple(p))
        if first.pieces is not None:
            drive = PiecewiseCubicDrive(
                model.drive.gain, model.drive.level, first.t, first.pieces.T
            )
            model = dataclasses.replace(model, drive=drive)
        start = np.tile(np.stack([self.states[r] for r in group]), (len(many), 1))
        zeros = np.stack([p[self.layout.index[n]] for n in ("zero1", "zero2")], axis=1)
        start[:, :2] -= zeros
        run = sweep(model, first.t, start, velocities=False, max_steps=STEPS * first.t.size)
        y = np.stack([run.phi1, run.phi2], axis=-1) + zeros[:, None]
        y = y.reshape(len(many), len(group), first.t.size, 2)
        data = np.stack([self.setting.prepared[r].y for r in group])
        with np.errstate(invalid="ignore", over="ignore"):
            squares = ((y - data) ** 2).mean(axis=2)[..., first.channels]
        return squares.mean(axis=-1).sum(axis=1)


def first_state(data: Prepared, recording: Recording) -> np.ndarray:
    """State (4,) at the first sample, as read: rest, unless the readings say otherwise.

    A decay is let go from anywhere, but from rest. Its angles are then those of the curve without
    a rate at its beginning: a polynomial that has one takes some of the bend for it, and so may
    have a small one by mistake.
    """
    state, sd = data.smooth[0].copy(), data.smooth_sd[0]
    slow = np.abs(state) < AT_REST * sd
    if recording.forced:
        return np.where(slow, 0.0, state)
    slow |= np.abs(state) < SLOW * np.abs(data.smooth).max(axis=0)
    part = stretches(data.t)[0]
    n = min(FIRST_SAMPLES, part.stop - part.start)
    since = data.t[:n] - data.t[0]
    for c in range(2):
        if slow[2 + c]:
            state[2 + c] = 0.0
            if n > len(POWERS):
                bent = (since / since[-1])[:, None] ** np.array(POWERS)
                state[c] = np.linalg.lstsq(bent, data.y[:n, c], rcond=None)[0][0]
    return state


def _groups(setting: Setting) -> list[list[int]]:
    """Fitted recordings by their times; a measured drive is a group of its own."""
    groups: list[list[int]] = []
    for r in setting.fitted:
        data = setting.prepared[r]
        for group in groups:
            other = setting.prepared[group[0]]
            alone = data.pieces is not None or other.pieces is not None
            if not alone and np.array_equal(data.t, other.t):
                group.append(r)
                break
        else:
            groups.append([r])
    return groups
