"""Residuals of a windowed fit in the order of time, with the motion they belong to."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from tp_jax.estimation.baseline import Setting
from tp_jax.estimation.least_squares import Fit

CHANNELS = ("phi1", "phi2")


class Series(NamedTuple):
    """One channel of one recording, (n,) each.

    recording: its label; channel: "phi1" or "phi2"; t [s]; residual: model minus measured, in units
    of the noise; angle [rad] and velocity [rad/s] of the model; window, row: where in a
    linearisation each residual stands.
    """

    recording: str
    channel: str
    t: Float[np.ndarray, " n"]
    residual: Float[np.ndarray, " n"]
    angle: Float[np.ndarray, " n"]
    velocity: Float[np.ndarray, " n"]
    window: Int[np.ndarray, " n"]
    row: Int[np.ndarray, " n"]


def series(fit: Fit, setting: Setting) -> tuple[Series, ...]:
    """All channels of all fitted recordings."""
    lin, w = fit.linearisation, fit.problem.windows
    out = []
    for i in setting.fitted:
        mine = np.flatnonzero(w.recording == i)
        mine = mine[np.argsort(w.first[mine])]
        for c, channel in enumerate(CHANNELS):
            if not setting.prepared[i].channels[c]:
                continue
            window = np.concatenate([np.full(w.count[j], j) for j in mine])
            sample = np.concatenate([np.arange(w.count[j]) for j in mine])
            t = setting.prepared[i].t[
                np.concatenate([w.first[j] + np.arange(w.count[j]) for j in mine])
            ]
            row = 2 * sample + c
            states = lin.states[window, sample]
            out.append(
                Series(
                    setting.recordings[i].label, channel, t, lin.r[window, row], states[:, c],
                    states[:, 2 + c], window, row,
                )
            )  # fmt: skip
    return tuple(out)
