"""The sensors' noise by channel, estimated with the fit rather than before it.

`recordings.noise_floor` takes the noise from the data's roughness: it needs no model, and it
counts nothing that is smooth. Here it is what a fitted model leaves: the maximum of the likelihood
over the two levels as well.
"""

import dataclasses
from collections.abc import Sequence

import numpy as np

from tp_jax.estimation.baseline import Setting
from tp_jax.estimation.least_squares import Fit
from tp_jax.estimation.windows import prepare
from tp_jax.recordings import Colour

CHANNELS = ("phi1", "phi2")


def fitted_noise(fit: Fit) -> dict[str, float]:
    """Standard deviation [rad] of each channel's residuals, estimated states and unknowns counted.

    Each window's state takes two degrees of freedom from each channel; the unknowns are shared
    out evenly.
    """
    problem = fit.problem
    w = problem.windows
    channels = problem.prepared[int(w.recording[0])].channels
    left = float(np.maximum(w.count - 2, 0).sum()) - len(fit.unknowns) / channels.sum()
    samples = fit.linearisation.r[:, :-4]
    out = {}
    for c, name in enumerate(CHANNELS):
        if channels[c]:
            squares = float((samples[:, c::2] ** 2).sum())
            out[name] = float(problem.sigma[c] * np.sqrt(squares / max(left, 1.0)))
    return out


def with_noise(
    setting: Setting,
    noise: dict[str, float],
    colours: Sequence[tuple[Colour, Colour]] | None = None,
) -> Setting:
    """A campaign with other noise levels, by channel [rad], and colours, by recording."""
    if colours is None:
        colours = [p.colour for p in setting.prepared]
    sigma = np.array([noise.get(n, s) for n, s in zip(CHANNELS, setting.sigma, strict=True)])
    by_name = dict(zip(CHANNELS, sigma, strict=True))
    pairs = zip(setting.recordings, setting.widths, strict=True)
    prepared = tuple(
        prepare(r, by_name, int(width), colour)
        for (r, width), colour in zip(pairs, colours, strict=True)
    )
    return dataclasses.replace(
        setting, noise={**setting.noise, **noise}, sigma=sigma, prepared=prepared
    )
