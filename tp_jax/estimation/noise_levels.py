"""The sensors' noise by channel, estimated with the fit rather than before it.

`recordings.noise_levels` takes the noise from the data's roughness: it needs no model, and it
counts nothing that is smooth. Here it is what a fitted model leaves: the maximum of the likelihood
over the two levels as well.
"""

import dataclasses
from collections.abc import Sequence

import numpy as np

from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.estimation.windows import prepare
from tp_jax.recordings import Colour

CHANNELS = ("phi1", "phi2")


def fitted_noise(fit: Fit) -> np.ndarray:
    """Level (2,) of each channel's residuals in units of the noise that was assumed.

    Each window's state takes two degrees of freedom from each channel; the unknowns are shared
    out evenly. 1 where a channel is missing.
    """
    problem = fit.problem
    w = problem.windows
    channels = problem.prepared[int(w.recording[0])].channels
    left = float(np.maximum(w.count - 2, 0).sum()) - len(fit.unknowns) / channels.sum()
    samples = fit.linearisation.r[:, :-4]
    squares = np.array([float((samples[:, c::2] ** 2).sum()) for c in range(2)])
    return np.where(channels, np.sqrt(squares / max(left, 1.0)), 1.0)


def with_noise(
    setting: PreparedCampaign,
    levels: np.ndarray,
    colours: Sequence[tuple[Colour, Colour]] | None = None,
) -> PreparedCampaign:
    """A campaign with other noise.

    Args:
        setting: the campaign.
        levels: (r, 2) [rad], of both channels in every recording.
        colours: of both channels in every recording; as they are if None.
    """
    if colours is None:
        colours = [p.colour for p in setting.prepared]
    every = zip(setting.recordings, levels, setting.widths, colours, strict=True)
    prepared = tuple(prepare(r, own, int(width), colour) for r, own, width, colour in every)
    return dataclasses.replace(setting, levels=levels, prepared=prepared)
