"""The sensors' noise, from what a fitted model leaves.

The angles alone show noise far above the motion only (`recordings.noise_colour`). Below, noise and
motion differ in that noise does not repeat: what a wrong model leaves is a function of the motion,
the same in every period, and noise is not. So the residuals of every recording are freed of all
that goes with its motion (harmonics of a commanded drive's phase, or polynomials of the states),
window states included, and the colour and level of the rest are estimated by restricted maximum
likelihood, for all recordings at one sampling rate together. Near the Nyquist frequency that level
must agree with what high-order differences of the data see: a rest with more is no noise, and what
there is then counts as gap. But a rest that is of one size in several recordings, whatever moves
there, and forgets itself within a few samples is noise, of a colour that two numbers do not have.
Of a motion as fast as the sampling, differences see a part: white noise is lowered to the rest.
"""

import dataclasses
import itertools
import logging
from collections.abc import Sequence

import numpy as np
from scipy import optimize

from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.noise_levels import CHANNELS, with_noise
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.estimation.residual_noise_policy import POLICY, ResidualNoisePolicy
from tp_jax.estimation.restricted_likelihood import Rest
from tp_jax.recordings import Colour, Recording, noise_levels, same_rate
from tp_jax.recordings.colour import limits
from tp_jax.recordings.noise import quantum, steps_hide

log = logging.getLogger(__name__)


WIDE = 0.08
"""First step of a correlation that is refined from the grid."""


def with_residual_noise(
    setting: PreparedCampaign, fit: Fit, policy: ResidualNoisePolicy = POLICY
) -> PreparedCampaign:
    """A campaign with the noise that a fit's residuals show.

    Args:
        setting: the campaign.
        fit: to its fitted recordings.
        policy: what decides.

    Returns:
        `setting` itself where nothing changes.
    """
    bare = without_residual_noise(setting)
    levels, colours = residual_noise(bare, fit, policy)
    if colours == [p.colour for p in setting.prepared] and np.allclose(levels, setting.levels):
        return setting
    return with_noise(bare, levels, colours)


def without_residual_noise(setting: PreparedCampaign) -> PreparedCampaign:
    """A campaign with what its data alone say of its noise."""
    levels, colours = setting.data_noise
    if list(colours) == [p.colour for p in setting.prepared]:
        return setting
    return with_noise(setting, levels, colours)


def residual_noise(
    setting: PreparedCampaign, fit: Fit, policy: ResidualNoisePolicy = POLICY
) -> tuple[np.ndarray, list[tuple[Colour, Colour]]]:
    """Levels (r, 2) [rad] and colours of both channels in every recording.

    Args:
        setting: a campaign with what its data alone say of its noise.
        fit: to its fitted recordings.
        policy: what decides.
    """
    fit = _under(setting, fit)
    colours = [p.colour for p in setting.prepared]
    levels = setting.levels.copy()
    for group in same_rate(setting.recordings):
        mine = [i for i in group if i in setting.fitted]
        if not mine:
            continue
        pair = list(colours[mine[0]])
        for c in range(2):
            if not setting.prepared[mine[0]].channels[c]:
                continue
            step = float(np.median(np.diff(setting.prepared[mine[0]].t)))
            rest = Rest(setting, fit, mine, c, policy)
            hidden = [
                steps_hide(setting.recordings[i].channels[CHANNELS[c]], setting.levels[i, c])
                for i in mine
            ]
            # what goes with the motion was taken out, and is noise all the same
            rounded = 2 * sum(hidden) > len(hidden)
            found = _estimated(rest, step / setting.period, policy)
            if found is None:
                if not rounded:
                    levels[group, c] = _lowered(levels[group, c], group, rest, policy)
                continue
            colour, rise = found
            if rounded:
                rise = max(rise, 1.0)
            seen = _seen([setting.recordings[i] for i in mine], c, colour)
            left = float(np.median((rise * setting.levels[mine, c] / seen) ** 2))
            log.info(
                "noise of channel %d: %s, left %.3g of what differences see", c + 1, colour, left
            )
            if left > (policy.most if rest.is_of_one_size(colour, policy) else policy.left):
                continue
            pair[c] = colour
            levels[group, c] *= rise
        for i in group:
            colours[i] = (pair[0], pair[1])
    return levels, colours


def _lowered(
    levels: np.ndarray, group: Sequence[int], rest: Rest, policy: ResidualNoisePolicy
) -> np.ndarray:
    """Levels (g,) [rad] of white noise, no higher than what is left in each recording of a group.

    Of a motion as fast as the sampling, differences see a part and take it for noise. Under too
    high a level nothing is fitted as closely as it could be, and whatever else is left where the
    level is right stands out. A recording that is not fitted then has no more than those that are:
    its differences see as much of the motion as theirs did.
    """
    out = np.array(levels)
    square, free = rest.squares(Colour())
    low = square < 1.0 - policy.apart - 3.0 * np.sqrt(2.0 / free)
    at = [list(group).index(i) for i in rest.recordings]
    if not low.any():
        return out
    out[at] = np.where(low, np.sqrt(square), 1.0) * out[at]
    out = np.minimum(out, out[at].max())
    log.info("noise of differences lowered to %s of it", np.round(out / levels, 3))
    return out


def _seen(recordings: Sequence[Recording], c: int, colour: Colour) -> np.ndarray:
    """Levels (r,) [rad] that differences of the readings see under a colour, at the most.

    Those of coarse readings are mostly zero and miss up to the whole error of rounding.
    """
    readings = [r.channels[CHANNELS[c]] for r in recordings]
    rounding = np.array([quantum(y) for y in readings]) / np.sqrt(12.0)
    levels = noise_levels(recordings, [(colour, colour)] * len(recordings))[:, c]
    return np.hypot(levels, np.minimum(rounding, levels))


def _under(setting: PreparedCampaign, fit: Fit) -> Fit:
    """A fit with its residuals in units of a campaign's noise, of which it may have known more."""
    colours = [p.colour for p in setting.prepared]
    known = [p.colour for p in fit.problem.prepared]
    levels = np.array([p.sigma for p in fit.problem.prepared])
    if known == colours and np.array_equal(levels, [p.sigma for p in setting.prepared]):
        return fit
    problem = dataclasses.replace(fit.problem, prepared=setting.prepared)
    lin = problem.linearise(fit.values, fit.states, ())
    return dataclasses.replace(fit, problem=problem, linearisation=lin)


def _estimated(rest: Rest, samples: float, policy: ResidualNoisePolicy):
    """Colour, and the standard deviation that goes with it in units of the campaign's; None where
    white is as good.

    Args:
        rest: of one channel. samples: a sampling interval over the motion's period.
    """
    if rest.n < policy.samples:
        return None
    steepest = float(np.exp(-2.0 * np.pi * policy.slowest * samples))
    part = rest.thinned(policy.looked)
    share = rest.n / max(part.n, 1)
    white, _ = part.deviance(Colour())
    tried = []
    for rho, way in itertools.product(policy.rho, policy.neighbours):
        if rho > steepest:
            continue
        edge = limits(rho)[1 if way > 0.0 else 0]
        tried.append((part.deviance(Colour(abs(way) * edge, rho))[0], abs(way) * edge, rho))
    least, c, rho = min(tried, default=(np.inf, 0.0, 0.0))
    near = white - least + policy.certain / share
    if near < 0.0:
        return None

    def cost(x: np.ndarray) -> float:
        c, rho = float(x[0]), float(np.clip(x[1], 0.0, steepest))
        low, high = limits(rho)
        return part.deviance(Colour(float(np.clip(c, low, high)), rho))[0]

    # about half as wide as the grid; SciPy's own simplex, a twentieth of a small number wide, ends
    # where it begins
    wide = WIDE if rho + WIDE <= steepest else -WIDE
    found = optimize.minimize(
        cost,
        (c, rho),
        method="Nelder-Mead",
        bounds=[(-0.5, 1.0), (0.0, steepest)],
        options={
            "xatol": 0.005,
            "fatol": 0.25,
            "maxfev": 80,
            "initial_simplex": [
                (c, rho),
                (c + WIDE * (-1.0 if c > 0.5 else 1.0), rho),
                (c, max(rho + wide, 0.0)),
            ],
        },
    )
    rho = float(np.clip(found.x[1], 0.0, steepest))
    c = float(np.clip(found.x[0], *limits(rho)))
    best = Colour(c, rho, of_residuals=True)
    white, _ = rest.deviance(Colour())
    least, left = rest.deviance(best)
    log.info(
        "residuals: neighbours %.3g, rho %.3g, deviance %.4g under white, mean square %.3g",
        c,
        rho,
        white - least,
        left,
    )
    if white - least < policy.certain or (abs(c) < policy.least and best.slow < policy.slow):
        return None
    return best, float(np.sqrt(left))
