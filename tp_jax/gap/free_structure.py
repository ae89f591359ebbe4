"""Is anything left that no effect of the catalogue need be like? A test without a candidate.

`structure` asks in the directions of the catalogue's effects. Here the residuals of every window
are held against what may go wrong with its readings (`free_torques`: errors of a sensor that are
slow, wander, jump or stutter, and times that are off), whose coefficients are random and belong to
the window. The score of a source's variance at zero is a sum of squares of the coefficients'
gradients,

    T = sum over windows of g_w' (I + tau C_w)^-1 g_w,   C_w = Var g_w with nothing but noise,

once with tau = 0, which finds a little of the source best, and once with more of it. Torques need
no columns of their own: what they do in half a second is slow in the readings too. What windows and
parameters absorb is projected out; T is compared with the residuals' own mean square, so that a
noise of another size is nothing. Its null distribution, a weighted sum of chi squares, is
Satterthwaite's.

Of a channel whose steps hide its noise nothing is asked: rounding then goes with the motion.

Source: Zhang, Lin (2003), Biostatistics 4, 57-74, for the test of a variance at zero.
"""

import dataclasses
from collections.abc import Sequence

import numpy as np

from tp_jax import _tails as tails
from tp_jax.estimation.elimination import eliminate
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.layout import Unknown
from tp_jax.estimation.linearisation import columns, gathered, places
from tp_jax.estimation.noise_levels import CHANNELS
from tp_jax.estimation.normal_equations import scaled_inverse
from tp_jax.estimation.parts import parts
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.gap import calibration
from tp_jax.gap.free_torques import (
    MOST_OF_A_SOURCE,
    MOST_OF_ALL,
    errors_of_readings,
    free_columns,
    harmonics_of,
    sources_of_errors,
)
from tp_jax.gap.policy import POLICY, StructurePolicy
from tp_jax.recordings.noise import steps_hide
from tp_jax.results.diagnosis import LackOfFit

#: Unknowns, (u, u) inverse information about them and a calibration's shapes, (u,) gradient.
Shared = tuple[Sequence[Unknown], np.ndarray, np.ndarray]

SIZES = (0.0, 10.0)  # tau
LEAST = 1e-12  # p: of the tail beyond, the approximation knows nothing


def free_structure(
    setting: PreparedCampaign, fit: Fit, policy: StructurePolicy = POLICY.structure
) -> LackOfFit:
    """Test that a fit leaves nothing but noise.

    Args:
        setting: the campaign.
        fit: at its optimum.
        policy: how well coloured noise is known.
    """
    coarse = _coarse(setting)
    noise = _mean_squares(fit)
    best = LackOfFit(1.0, "", 1.0)
    tests = 0
    known = 1.0 + (policy.colour if fit.problem.coloured else 0.0)
    shared = _of_all_windows(setting, fit)
    for name in sources_of_errors(setting, fit):
        if _channels(name) & coarse:
            continue
        # one source at a time: the columns of all would be the largest array of a diagnosis
        scores = free_scores(setting, fit, name, shared)
        value, z = scores.of(name)
        phi = noise[sorted(_channels(name))].mean()
        for tau in SIZES:
            weights = value / (1.0 + tau * value)
            mean, square = weights.sum(), (weights**2).sum()
            tests += 1
            if not (mean > 0.0 and phi > 0.0):
                continue
            ratio = float((z**2 / (1.0 + tau * value)).sum() / (mean * phi))
            p = float(tails.fisher(ratio / known, mean**2 / square, max(fit.dof, 1)))
            if p < best.p or not best.source:
                best = LackOfFit(p, name, ratio)
    return dataclasses.replace(best, p=float(np.clip(best.p * max(tests, 1), LEAST, 1.0)))


@dataclasses.dataclass(frozen=True)
class FreeScores:
    """Scores of what is free in every window, with nothing but noise in it.

    g: (w, q) gradients by the coefficients, what windows and parameters absorb projected out;
    covariance: (w, q, q) theirs; unit: (q,) of each coefficient, in which what the mean window
    tells of it has variance one, times its weight among those of its source; source: (q,).
    """

    g: np.ndarray
    covariance: np.ndarray
    unit: np.ndarray
    source: np.ndarray

    def of(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """A source's coefficients (k,) in axes of their own: variances and scores (w, k) there."""
        mine = np.flatnonzero(self.source == name)
        scaled = self.unit[mine]
        part = self.covariance[:, mine][:, :, mine] * np.outer(scaled, scaled)
        value, vector = np.linalg.eigh(part)
        z = np.einsum("wji,wj->wi", vector, self.g[:, mine] * scaled)
        return np.maximum(value, 0.0), z


def free_scores(
    setting: PreparedCampaign, fit: Fit, source: str | None = None, shared: Shared | None = None
) -> FreeScores:
    """Scores of the coefficients of free columns at zero.

    Args:
        setting: the campaign. fit: at its optimum.
        source: of errors of readings; all that is free, torques too, if None.
        shared: as of `_of_all_windows`, if it is known already.
    """
    base, inverse, pull = _of_all_windows(setting, fit) if shared is None else shared
    g, covariance, told = [], [], []
    highest = harmonics_of(fit)
    for _, part in parts(fit, len(base) + (MOST_OF_A_SOURCE if source else MOST_OF_ALL)):
        if source is None:
            free = free_columns(setting, part, highest)
        else:
            free = errors_of_readings(setting, part, source, highest)
        own, to, _ = _shared(setting, part, base)
        jac = np.concatenate([free.jac, own], axis=2)
        left = eliminate(part.linearisation.r, part.linearisation.states_jac, jac)
        q = free.source.size
        H = left.H[:, :q, :q]
        # a column of no unknown, as of a recording whose own number is at a bound, takes nothing
        across = np.where(to[:, None, :] >= 0, left.H[:, :q, q:], 0.0)
        back = inverse[to[:, :, None], to[:, None, :]] @ across.transpose(0, 2, 1)
        covariance.append(H - across @ back)
        g.append(left.g[:, :q] - (across @ (inverse @ pull)[to][:, :, None])[:, :, 0])
        told.append(np.einsum("wii->i", H))
    mean = np.sum(told, axis=0) / fit.problem.windows.n
    unit = free.weight / np.sqrt(np.maximum(mean, 1e-300))
    return FreeScores(np.concatenate(g), np.concatenate(covariance), unit, free.source)


def _of_all_windows(setting: PreparedCampaign, fit: Fit) -> Shared:
    """Unknowns that windows share, inverse information about them, and the gradient by them."""
    moved = np.flatnonzero(~np.asarray(fit.at_bound, dtype=bool))
    base = [fit.unknowns[i] for i in moved]
    sums = []
    for _, part in parts(fit, len(base)):
        own, to, u = _shared(setting, part, base)
        left = eliminate(part.linearisation.r, part.linearisation.states_jac, own)
        sums.append((gathered(left.H, to, u), gathered(left.g, to, u)))
    H, pull = (np.sum(each, axis=0) for each in zip(*sums, strict=True))
    u = len(pull)
    H[np.arange(u), np.arange(u)] += np.r_[fit.normal().prior[moved], np.ones(u - len(base))]
    inverse = scaled_inverse(H)
    # the fit knows nothing of the calibration's error: what that explains is taken off here
    pull[: len(base)] = 0.0
    return base, inverse, pull


def _shared(
    setting: PreparedCampaign, part: Fit, base: Sequence[Unknown]
) -> tuple[np.ndarray, np.ndarray, int]:
    """Derivatives (w, m, d) by what windows share: unknowns, by slot, and a calibration's shapes.

    Also where columns stand among all of these (w, d), and how many there are.
    """
    lin, slots = part.linearisation, columns(base)
    shapes = calibration.columns(setting, part)
    u = len(base) + shapes.shape[2]
    of_shapes = np.broadcast_to(np.arange(len(base), u), (len(lin.r), u - len(base)))
    to = np.concatenate([places(base, slots, lin.recording), of_shapes], axis=1)
    return np.concatenate([lin.by_slot(slots), shapes], axis=2), to, u


def _channels(source: str) -> set[int]:
    """The sensors whose readings a source changes."""
    return {"sensor1": {0}, "sensor2": {1}}.get(source.split()[0], {0, 1})


def _coarse(setting: PreparedCampaign) -> set[int]:
    """Channels whose steps hide their noise."""
    return {
        c
        for c, name in enumerate(CHANNELS)
        for i in setting.fitted
        if (readings := setting.recordings[i].channels.get(name)) is not None
        and steps_hide(readings, setting.levels[i, c])
    }


def _mean_squares(fit: Fit) -> np.ndarray:
    """(2,) of the residuals of each channel per degree of freedom, 0 for one not there.

    Where each window's state fits best.
    """
    lin = fit.linearisation
    none = np.zeros((*lin.r.shape, 0))
    step = eliminate(lin.r, lin.states_jac, none).state_step
    r = lin.r + np.einsum("wmx,wx->wm", lin.states_jac, step)
    valid = fit.linearisation.valid[:, :-4].reshape(len(r), -1, 2)
    squares = ((r[:, :-4].reshape(valid.shape) ** 2) * valid).sum(axis=(0, 1))
    samples = valid.sum(axis=(0, 1))
    left = samples * fit.dof / max(samples.sum(), 1)
    return np.where(left > 0.0, squares / np.maximum(left, 1e-300), 0.0)
