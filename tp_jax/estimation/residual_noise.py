"""The colour of the sensors' noise, from what a fitted model leaves.

Where the sampling is slow against the motion no band is left in which noise stands alone
(`recordings.noise_colour`). Then the difference is that noise does not repeat: what a wrong model
leaves is a function of the motion, the same in every period, and noise is not. So the residuals of
every recording are freed of all that goes with its motion (harmonics of a commanded drive's phase,
or polynomials of the states), window states included, and the colour of the rest is estimated by
restricted maximum likelihood. Its level near the Nyquist frequency stays what high-order
differences of the data see; a colour only says how much more there is below. A rest that no colour
explains is no noise: the noise then stays white, and what there is counts as gap.

Source: Patterson, Thompson (1971), Biometrika 58, 545-554.
"""

import dataclasses
import itertools
import logging
from collections.abc import Sequence

import numpy as np
from scipy import optimize

from tp_jax.estimation.baseline import Setting
from tp_jax.estimation.least_squares import Fit
from tp_jax.estimation.noise_levels import CHANNELS, with_noise
from tp_jax.recordings import Colour, same_rate
from tp_jax.recordings.noise import quantum
from tp_jax.recordings.noise_colour import first_order

log = logging.getLogger(__name__)


@dataclasses.dataclass(frozen=True)
class ResidualNoisePolicy:
    """What decides about a colour.

    Attributes:
        harmonics: of a commanded drive's phase that belong to the motion.
        degree: of the polynomials that stand for it elsewhere, of a column alone and with a rider.
        rho: correlations of neighbouring samples that are tried first. white: parts of the
            variance. From the best of them a simplex search goes on.
        slowest: corner frequency of the noise's filter over the frequency of the motion, at least;
            slower noise and a gap that repeats every period cannot be told apart.
        trimmed: windows that leave more than this many medians are left out: transients.
        certain: fall of twice the negative log-likelihood from which noise is coloured.
        least: rise of the standard deviation below which colour is not worth its trouble.
        rounded: part of the noise's standard deviation that rounding may have; more, and it is
            white.
        left: mean square that may be left, in units of the noise, for it to be noise.
    """

    harmonics: int = 8
    degree: tuple[int, int] = (5, 3)
    rho: tuple[float, ...] = (0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.85, 0.9)
    white: tuple[float, ...] = (0.0, 0.15, 0.3, 0.5, 0.7, 0.85)
    slowest: float = 0.5
    trimmed: float = 3.0
    certain: float = 24.0
    least: float = 1.05
    left: float = 1.25
    rounded: float = 0.7


POLICY = ResidualNoisePolicy()


def with_residual_noise(
    setting: Setting, fit: Fit, policy: ResidualNoisePolicy = POLICY
) -> Setting:
    """A campaign with the noise that a fit's residuals show, where its data alone do not.

    Args:
        setting: the campaign, whose noise near the Nyquist frequency is known.
        fit: to its fitted recordings.
        policy: what decides.

    Returns:
        `setting` itself where nothing changes.
    """
    bare = without_residual_noise(setting)
    found = residual_colours(bare, fit, policy)
    if found == [p.colour for p in setting.prepared]:
        return setting
    rise = _rise(setting, found)
    noise = {name: level * rise[CHANNELS.index(name)] for name, level in bare.noise.items()}
    return with_noise(bare, noise, found)


def without_residual_noise(setting: Setting) -> Setting:
    """A campaign with what its data alone say of its noise."""
    colours = [tuple(Colour() if c.of_residuals else c for c in p.colour) for p in setting.prepared]
    if colours == [p.colour for p in setting.prepared]:
        return setting
    rise = _rise(setting, [p.colour for p in setting.prepared])
    noise = {name: level / rise[CHANNELS.index(name)] for name, level in setting.noise.items()}
    return with_noise(setting, noise, colours)


def _rise(setting: Setting, colours: Sequence[tuple[Colour, Colour]]) -> list[float]:
    """How much higher each channel's noise is by what residuals showed, over fitted recordings.

    What the data showed by themselves is in its level already.
    """
    mine = [colours[i] for i in setting.fitted]
    return [
        float(np.median([pair[c].excess if pair[c].of_residuals else 1.0 for pair in mine]))
        for c in range(2)
    ]


def residual_colours(
    setting: Setting, fit: Fit, policy: ResidualNoisePolicy = POLICY
) -> list[tuple[Colour, Colour]]:
    """Colours of both channels in every recording.

    Args:
        setting: a campaign with what its data alone say of its noise.
        fit: to its fitted recordings.
        policy: what decides.
    """
    fit = _under(setting, fit)
    found = [p.colour for p in setting.prepared]
    for group in same_rate(setting.recordings):
        mine = [i for i in group if i in setting.fitted]
        if not mine:
            continue
        pair = list(found[mine[0]])
        for c in range(2):
            unknown = pair[c].is_white and not pair[c].lowest
            if unknown and setting.prepared[mine[0]].channels[c]:
                if _rounded(setting, mine, c, policy):
                    continue
                step = float(np.median(np.diff(setting.prepared[mine[0]].t)))
                pair[c] = _colour(setting, fit, mine, c, step / setting.period, policy)
        for i in group:
            found[i] = (pair[0], pair[1])
    return found


def _under(setting: Setting, fit: Fit) -> Fit:
    """A fit with its residuals in units of a campaign's noise, of which it may have known more."""
    colours = [p.colour for p in setting.prepared]
    known = [p.colour for p in fit.problem.prepared]
    if known == colours and np.array_equal(fit.problem.sigma, setting.sigma):
        return fit
    problem = dataclasses.replace(fit.problem, prepared=setting.prepared, sigma=setting.sigma)
    lin = problem.linearise(fit.values, fit.states, ())
    return dataclasses.replace(fit, problem=problem, linearisation=lin)


def _rounded(setting: Setting, group: Sequence[int], c: int, policy: ResidualNoisePolicy) -> bool:
    """Whether most of a channel's noise is rounding, which is white where a body moves."""
    name = CHANNELS[c]
    steps = [quantum(setting.recordings[i].channels[name]) for i in group]
    return float(np.median(steps)) / np.sqrt(12.0) > policy.rounded * setting.noise[name]


def _colour(
    setting: Setting, fit: Fit, group: Sequence[int], c: int, samples: float, policy
) -> Colour:
    """Colour of one channel; `samples`: a sampling interval over the motion's period."""
    rest = _Rest(setting, fit, group, c, policy)
    if rest.n < 50:
        return Colour()
    steepest = np.exp(-2.0 * np.pi * policy.slowest * samples)
    white, _ = rest.deviance(Colour())
    tried = [
        (rest.deviance(first_order(rho, part))[0], rho, part)
        for rho, part in itertools.product(policy.rho, policy.white)
        if rho <= steepest
    ]
    least, rho, part = min(tried, default=(np.inf, 0.0, 1.0))
    if white - least < policy.certain:
        return Colour()
    found = optimize.minimize(
        lambda x: rest.deviance(first_order(*x))[0], (rho, part), method="Nelder-Mead",
        bounds=[(0.0, steepest), (0.0, 0.98)], options={"xatol": 0.01, "fatol": 0.5},
    )  # fmt: skip
    best = first_order(*found.x)
    least, left = rest.deviance(best)
    log.info(
        "noise of channel %d: %s, deviance %.4g under white, mean square %.3g",
        c + 1, f"rho {best.rho:g}, white {best.white:g}", white - least, left,
    )  # fmt: skip
    if best.excess < policy.least or left > policy.left:
        return Colour()
    return dataclasses.replace(best, of_residuals=True)


class _Rest:
    """Residuals of one channel in some recordings, without what goes with the motion."""

    def __init__(self, setting: Setting, fit: Fit, group: Sequence[int], c: int, policy):
        lin, w = fit.linearisation, fit.problem.windows
        n = lin.n_samples
        rows = slice(c, 2 * n, 2)
        self.parts = []
        for i in group:
            mine = np.flatnonzero((w.recording == i) & lin.complete)
            if not mine.size:
                continue
            inside = np.arange(n)[None, :] < w.count[mine][:, None]
            F = _features(setting, i, w.first[mine], lin.states[mine], policy) * inside[:, :, None]
            size = np.sqrt((F**2).sum(axis=(0, 1)))
            F = F[:, :, size > 0.0] / size[size > 0.0]
            table = np.concatenate(
                [lin.samples[mine][:, rows, None], _scaled(lin.states_jac[mine][:, rows]), F], 2
            )
            self.parts.append((table * inside[:, :, None], inside))
        self.parts = [self._kept(table, inside, policy) for table, inside in self.parts]
        self.n = sum(int(inside.sum()) for _, inside in self.parts)

    def _kept(self, table, inside, policy):
        """Without transients."""
        _, by_window, _ = _projected(table)
        mean = by_window / np.maximum(inside.sum(axis=1) - 4, 1)
        keep = mean <= policy.trimmed * max(float(np.median(mean)), 1e-300)
        return table[keep], inside[keep]

    def deviance(self, colour: Colour) -> tuple[float, float]:
        """Twice the negative restricted log-likelihood, and the mean square that is left."""
        total, squares, free = 0.0, 0.0, 0.0
        for table, inside in self.parts:
            white = colour.whiten(table, axis=1) * inside[:, :, None] / colour.excess
            rss, _, (logdet, used) = _projected(white)
            count = inside.sum(axis=1)
            total += rss + logdet + _log_determinant(colour, count)
            squares, free = squares + rss, free + count.sum() - used
        return total, squares / max(free, 1.0)


def _log_determinant(colour: Colour, count: np.ndarray) -> float:
    """Of the covariance of windows of so many samples."""
    scale = 2.0 * np.log(colour.excess) * float(count.sum())
    if colour.is_white:
        return scale
    out = scale
    for n, times in zip(*np.unique(count, return_counts=True), strict=True):
        unit = np.eye(min(int(n), len(colour.ar) + 1))
        # the whitening is lower triangular, and its diagonal is constant after the first rows
        diagonal = np.diag(colour.whiten(unit))
        tail = max(int(n) - len(diagonal), 0)
        out -= 2.0 * times * float(np.log(diagonal).sum() + tail * np.log(diagonal[-1]))
    return out


def _scaled(jac: np.ndarray) -> np.ndarray:
    size = np.sqrt((jac**2).sum(axis=1, keepdims=True))
    return jac / np.where(size > 0.0, size, 1.0)


def _projected(table: np.ndarray):
    """Residual sum of squares, that of each window (w,), and the restricted likelihood's
    determinant with the number of columns that were used.

    Args:
        table: (w, n, 1 + 4 + q): residuals, derivatives by the window's states, features.
    """
    y, S, F = table[:, :, :1], table[:, :, 1:5], table[:, :, 5:]
    left, values, _ = np.linalg.svd(S, full_matrices=False)
    live = values > 1e-6 * values[:, :1]
    basis = left * live[:, None, :]
    logdet = 2.0 * float(np.log(values[live]).sum())
    used = float(live.sum())
    rest = np.concatenate([y, F], axis=2)
    rest = rest - basis @ (basis.transpose(0, 2, 1) @ rest)
    y, F = rest[:, :, 0], rest[:, :, 1:]
    A = np.einsum("wnp,wnq->pq", F, F)
    value, vector = np.linalg.eigh(A)
    seen = value > 1e-8 * max(float(value.max(initial=0.0)), 1e-300)
    logdet += float(np.log(value[seen]).sum())
    used += float(seen.sum())
    b = np.einsum("wnp,wn->p", F, y)
    coefficients = vector[:, seen] @ ((vector[:, seen].T @ b) / value[seen])
    by_window = ((y - F @ coefficients) ** 2).sum(axis=1)
    return float(by_window.sum()), by_window, (logdet, used)


def _features(setting: Setting, i: int, first: np.ndarray, states: np.ndarray, policy):
    """What goes with the motion of a recording in its windows (w, n, q)."""
    r, p = setting.recordings[i], setting.prepared[i]
    w, n = states.shape[:2]
    at = np.minimum(first[:, None] + np.arange(n)[None, :], p.t.size - 1)
    if r.forced and r.omega is not None and not r.measured_drive:
        angle = r.omega * p.t[at]
        waves = [np.ones((w, n))]
        for j in range(1, policy.harmonics + 1):
            waves += [np.sin(j * angle), np.cos(j * angle)]
        return np.stack(waves, axis=2)
    columns = [states[..., k] for k in ((0, 2) if not setting.rider else (0, 1, 2, 3))]
    degree = policy.degree[1 if setting.rider else 0]
    if r.drive is not None:
        columns.append(r.drive[at])
        degree = policy.degree[1]
    unit = [(x - x.mean()) / max(float(np.abs(x - x.mean()).max()), 1e-300) for x in columns]
    out = [np.ones((w, n))]
    for d in range(1, degree + 1):
        for powers in itertools.combinations_with_replacement(range(len(unit)), d):
            out.append(np.prod([unit[k] for k in powers], axis=0))
    return np.stack(out, axis=2)
