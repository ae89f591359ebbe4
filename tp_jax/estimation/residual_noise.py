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

Source: Patterson, Thompson (1971), Biometrika 58, 545-554.
"""

import copy
import dataclasses
import itertools
import logging
from collections.abc import Sequence

import numpy as np
from scipy import optimize

from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.noise_levels import CHANNELS, with_noise
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.recordings import Colour, Recording, noise_levels, same_rate
from tp_jax.recordings.colour import limits
from tp_jax.recordings.noise import quantum, steps_hide

log = logging.getLogger(__name__)


@dataclasses.dataclass(frozen=True)
class ResidualNoisePolicy:
    """Thresholds that decide about a colour.

    Attributes:
        harmonics: of a commanded drive's phase that belong to the motion.
        degree: of the polynomials that stand for it elsewhere, of a column alone and with a rider.
        rho: factors from lag to lag that are tried first. neighbours: correlations of neighbouring
            samples, in parts of what is possible with a factor. From the best of them a simplex
            search goes on.
        looked: samples, of evenly spread windows, on which that search is made: they tell a
            correlation to .02, and the whole costs a second.
        slowest: corner frequency of the noise's filter over the frequency of the motion, at least;
            slower noise and a gap that repeats every period cannot be told apart.
        trimmed: windows that leave more than this many medians are left out: transients.
        certain: fall of twice the negative log-likelihood from which noise is coloured.
        least: correlation of neighbours below which colour is not worth its trouble, unless it
            raises the error of a mean by `slow`.
        slow: see `least`.
        left: mean square that may be left, over that which high-order differences see under the
            same colour, for it to be noise.
        samples: below which residuals say nothing of a colour.
        apart: part, beyond three standard errors of so many samples, by which the mean square of a
            recording differs from that of all at most, for a rest to be of one size. What
            friction, springs and drives leave is another at another frequency.
        recordings: that are of one size, at least.
        short: error of a mean, over that of white noise, up to which a rest forgets itself soon.
        most: as `left`, of a rest of one size: an autoregression of two lags whose spectrum peaks
            halfway to the Nyquist frequency has up to twice what differences see.
    """

    harmonics: int = 8
    degree: tuple[int, int] = (5, 3)
    rho: tuple[float, ...] = (0.0, 0.3, 0.5, 0.7, 0.85, 0.93, 0.97)
    neighbours: tuple[float, ...] = (-0.7, -0.4, -0.15, 0.1, 0.3, 0.6, 0.85)
    looked: int = 4000
    slowest: float = 0.5
    trimmed: float = 3.0
    certain: float = 24.0
    least: float = 0.05
    slow: float = 1.1
    left: float = 1.25
    samples: int = 50
    apart: float = 0.1
    recordings: int = 3
    short: float = 2.0
    most: float = 2.5


POLICY = ResidualNoisePolicy()

WIDE = 0.08
"""First step of a correlation that is refined from the grid."""

SPANNED = 1e-3
"""Part of the largest derivative, and of the largest singular value, that spans a direction."""

FOLLOWED = 1e-4
"""Part of the largest singular value from which a direction of what goes with the motion counts."""


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
            rest = _Rest(setting, fit, mine, c, policy)
            found = _estimated(rest, step / setting.period, policy)
            if found is None:
                continue
            colour, rise = found
            hidden = [
                steps_hide(setting.recordings[i].channels[CHANNELS[c]], setting.levels[i, c])
                for i in mine
            ]
            if 2 * sum(hidden) > len(hidden):
                # what goes with the motion was taken out, and is noise all the same
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


def _estimated(rest: "_Rest", samples: float, policy: ResidualNoisePolicy):
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


class _Rest:
    """Residuals of one channel in some recordings, without what goes with the motion."""

    def __init__(self, setting: PreparedCampaign, fit: Fit, group: Sequence[int], c: int, policy):
        lin, w = fit.linearisation, fit.problem.windows
        n = lin.n_samples
        rows = slice(c, 2 * n, 2)
        self.parts = []
        for i in group:
            mine = np.flatnonzero((w.recording == i) & lin.complete)
            mine = mine[_moving(setting, i, c, w.first[mine], w.count[mine])]
            if not mine.size:
                continue
            inside = np.arange(n)[None, :] < w.count[mine][:, None]
            F = _features(setting, i, w.first[mine], lin.states[mine], policy) * inside[:, :, None]
            size = np.sqrt((F**2).sum(axis=(0, 1)))
            F = F[:, :, size > 0.0] / size[size > 0.0]
            table = np.concatenate(
                [lin.samples[mine][:, rows, None], _basis(lin.states_jac[mine][:, rows]), F], 2
            )
            self.parts.append((table * inside[:, :, None], inside))
        self.parts = [self._kept(table, inside, policy) for table, inside in self.parts]
        self.n = sum(int(inside.sum()) for _, inside in self.parts)

    def _kept(self, table, inside, policy):
        """Without transients."""
        _, by_window, _ = _projected(_with_directions(table))
        mean = by_window / np.maximum(inside.sum(axis=1) - 4, 1)
        keep = mean <= policy.trimmed * max(float(np.median(mean)), 1e-300)
        return _with_directions(table[keep]), inside[keep]

    def is_of_one_size(self, colour: Colour, policy: ResidualNoisePolicy) -> bool:
        """True where recordings have the same of it under a colour, and it forgets itself soon."""
        if len(self.parts) < policy.recordings or colour.slow > policy.short:
            return False
        square, free = np.zeros(len(self.parts)), np.zeros(len(self.parts))
        for i, (table, inside) in enumerate(self.parts):
            rss, _, (_, used) = _projected(colour.whiten(table, axis=1) * inside[:, :, None])
            square[i], free[i] = rss, max(float(inside.sum()) - used, 1.0)
        apart = np.abs(square / free / (square.sum() / free.sum()) - 1.0)
        return bool(np.all(apart <= policy.apart + 3.0 * np.sqrt(2.0 / free)))

    def thinned(self, most: int) -> "_Rest":
        """Some of its windows, evenly spread over the recordings, of about so many samples."""
        every = int(np.ceil(self.n / most))
        if every <= 1:
            return self
        out = copy.copy(self)
        out.parts = [
            (_with_directions(table[::every]), inside[::every]) for table, inside in self.parts
        ]
        out.n = sum(int(inside.sum()) for _, inside in out.parts)
        return out

    def deviance(self, colour: Colour) -> tuple[float, float]:
        """Twice the negative restricted log-likelihood at the best level, and its square."""
        determinant, squares, free = 0.0, 0.0, 0.0
        for table, inside in self.parts:
            white = colour.whiten(table, axis=1) * inside[:, :, None]
            rss, _, (logdet, used) = _projected(white)
            count = inside.sum(axis=1)
            sizes, times = np.unique(count, return_counts=True)
            determinant += logdet + sum(
                t * colour.log_determinant(int(n)) for n, t in zip(sizes, times, strict=True)
            )
            squares, free = squares + rss, free + count.sum() - used
        level = squares / max(free, 1.0)
        return float(free * np.log(max(level, 1e-300)) + determinant), float(level)


def _moving(
    setting: PreparedCampaign, i: int, c: int, first: np.ndarray, count: np.ndarray
) -> np.ndarray:
    """Windows (w,) of a channel of a recording whose readings take more than two values.

    A body that rests between two steps of a coarse reading shows no noise at all: of such windows
    the noise of those that move would seem too small.
    """
    y = setting.prepared[i].y[:, c]
    step = quantum(setting.recordings[i].channels[CHANNELS[c]])
    spans = [np.ptp(y[f : f + n]) for f, n in zip(first, count, strict=True)]
    return np.array(spans) > 1.5 * step


def _basis(jac: np.ndarray) -> np.ndarray:
    """Orthonormal columns (w, n, 4) that span the derivatives by the states, zeros where fewer do.

    A body that stuck answers to its own velocity with rounding errors: those must count under
    every colour or under none, so they are left out once and for all.
    """
    size = np.sqrt((jac**2).sum(axis=1, keepdims=True))
    largest = size.max(axis=2, keepdims=True)
    unit = np.where(size > SPANNED * largest, jac / np.maximum(size, 1e-300), 0.0)
    left, values, _ = np.linalg.svd(unit, full_matrices=False)
    return left * (values > SPANNED * values[:, :1])[:, None, :]


def _with_directions(table: np.ndarray) -> np.ndarray:
    """The table with orthonormal features, states apart, and as many as these windows tell apart.

    As with the states: a direction that is there under one colour and not under another would
    decide between them. Slow colours won so, by the logarithm of a small number for each.
    """
    F = _beside_states(table[:, :, 1:5], table[:, :, 5:])[0]
    _, values, along = np.linalg.svd(F.reshape(-1, F.shape[2]), full_matrices=False)
    kept = values > FOLLOWED * values.max(initial=0.0)
    return np.concatenate([table[:, :, :5], F @ (along[kept].T / values[kept])], axis=2)


def _beside_states(S: np.ndarray, x: np.ndarray):
    """Columns x (w, n, q) less what the states' S (w, n, 4) follow; also the latter's singular
    values (w, 4), and which of them count.
    """
    left, values, _ = np.linalg.svd(S, full_matrices=False)
    live = values > 1e-6 * values[:, :1]
    basis = left * live[:, None, :]
    return x - basis @ (basis.transpose(0, 2, 1) @ x), values, live


def _projected(table: np.ndarray):
    """Residual sum of squares, that of each window (w,), and the restricted likelihood's
    determinant with the number of columns that were used.

    Args:
        table: (w, n, 1 + 4 + q): residuals, derivatives by the window's states, features.
    """
    rest, values, live = _beside_states(table[:, :, 1:5], np.delete(table, range(1, 5), axis=2))
    logdet = 2.0 * float(np.log(values[live]).sum())
    used = float(live.sum())
    flat = rest.reshape(-1, rest.shape[2])
    products = flat.T @ flat
    value, vector = np.linalg.eigh(products[1:, 1:])
    seen = value > 1e-13 * max(float(value.max(initial=0.0)), 1e-300)  # a colour takes none away
    logdet += float(np.log(value[seen]).sum())
    used += float(seen.sum())
    coefficients = vector[:, seen] @ ((vector[:, seen].T @ products[1:, 0]) / value[seen])
    weights = np.append(1.0, -coefficients)
    by_window = ((flat @ weights).reshape(rest.shape[:2]) ** 2).sum(axis=1)
    return float(by_window.sum()), by_window, (logdet, used)


def _features(setting: PreparedCampaign, i: int, first: np.ndarray, states: np.ndarray, policy):
    """Returns what goes with the motion of a recording in its windows (w, n, q)."""
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
