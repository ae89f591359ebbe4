"""The gap on held-out recordings: windowed errors, the part that is gone, its interval.

Read after the search for causes; only `unpredicted` reads them in between, and fits them then.
"""

import dataclasses
from collections.abc import Sequence

import numpy as np
from scipy.linalg import matmul_toeplitz

from tp_jax import _tails as tails
from tp_jax.effects import Effect
from tp_jax.estimation.drive_errors import put_right
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.from_readings import fit_from_readings
from tp_jax.estimation.layout import Unknown, Values
from tp_jax.estimation.normal_equations import scaled_inverse
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.estimation.priors import GaussianPrior
from tp_jax.gap.calibration import Floor, noise_alone
from tp_jax.gap.refit import nuisances
from tp_jax.recordings import Colour

FLOOR_ERROR = 0.03  # relative standard error of the noise variance, from its estimator, at least
PER_SAMPLE = 3.0  # times the root of the samples: fifth differences, and a median over recordings
FEW = 6  # windows, of which resampling alone would promise too much
DRAWS = 2000
LEAST_SCATTER = 0.1  # of a typical size, of those that each recording has: two may agree by chance


@dataclasses.dataclass(frozen=True)
class HeldOut:
    """Windowed errors of one model on the held-out recordings.

    squares: (w, 2) sums of squares [rad^2] by window and channel; samples: (w, 2) what noise alone
    would make of them in units of its variance: samples less estimated states, and less or more
    where it is coloured; fit: the fit of the window states; complete: whether the model could be
    integrated through all windows (those through which it could not have neither squares nor
    samples); scatter: (w, 2) half the variance of the squares of noise alone, in units of the
    square of its variance (`samples` if None); setting: the campaign, with noisy drives of these
    recordings put right under the model, if it does so (`drive_errors`).
    """

    squares: np.ndarray
    samples: np.ndarray
    fit: Fit
    complete: bool = True
    scatter: np.ndarray | None = None
    setting: PreparedCampaign | None = None

    def mean_square(self, weight: np.ndarray | None = None) -> float:
        """Mean over channels of their mean squares [rad^2]; `weight` (w,) counts windows.

        NaN where there is no sample.
        """
        w = np.ones(self.squares.shape[0]) if weight is None else weight
        used = self.samples.sum(axis=0) > 0
        if not used.any():
            return float("nan")
        total = (w[:, None] * self.squares).sum(axis=0)[used]
        count = (w[:, None] * self.samples).sum(axis=0)[used]
        return float((total / np.maximum(count, 1.0)).mean())

    def chance(self, levels: np.ndarray) -> float:
        """Relative standard error of `mean_square` where nothing but noise is left.

        Args:
            levels: (2,) noise of the channels [rad].
        """
        scatter = (self.samples if self.scatter is None else self.scatter).sum(axis=0)
        count = self.samples.sum(axis=0)
        used = count > 0
        if not used.any():
            return float("inf")
        square = levels[used] ** 2
        error = square * np.sqrt(2.0 * scatter[used]) / count[used]
        return float(np.sqrt((error**2).sum()) / square.sum())


def expected_elsewhere(
    values: Values, setting: PreparedCampaign, seen: Sequence[int], elsewhere: Sequence[int]
) -> Values:
    """Numbers for recordings that were not fitted, of what belongs to one recording.

    The mean of those that were; of an effect's amplitude, which may be the same in all runs or
    another in each, as much of it as the runs have in common. Where only differences between runs
    matter (`Effect.relative`) the mean is the parameter's, whatever the runs have in common.

    Args:
        values: of a fit. setting: its campaign.
        seen: recordings that were fitted. elsewhere: the others.
    """
    if not len(elsewhere):
        return values
    seen, elsewhere = list(seen), list(elsewhere)
    table = values.table.copy()
    owner = {e.qualified(a.name): e for e in setting.layout.effects for a in e.amplitudes}
    for i, p in enumerate(setting.layout.parameters):
        if p.scope == "recording" and p.name not in FIXED_BY_RECORDING:
            effect = owner.get(p.name)
            told = table[i, (effect and _moved(values, effect, seen)) or seen]
            absolute = effect is not None and not effect.relative
            table[i, elsewhere] = _in_common(told) if absolute else told.mean()
    return Values(values.layout, table)


def _moved(values: Values, effect: Effect, recordings: Sequence[int]) -> list[int]:
    """Recordings whose motion tells an effect: a motor that stands tells nothing of its speed."""
    running = values.table[values.layout.index["running"]]
    return [i for i in recordings if running[i] > 0.0 or "sine" not in effect.needs]


def _in_common(x: np.ndarray) -> float:
    """Estimates another run's value: the mean, drawn to zero by as much as chance would make it.

    The square of a mean is too large by the mean's variance, on average; what is left of it says
    how far the runs agree (an empirical Bayes factor by moments, zero at least).
    """
    if x.size == 1:
        return float(x[0])
    mean, error = float(x.mean()), float(x.var(ddof=1)) / x.size
    return mean * max(0.0, 1.0 - error / max(mean**2, 1e-300))


FIXED_BY_RECORDING = ("omega", "running", "metered", "drift_middle", "drift_rate")


def evaluate(
    setting: PreparedCampaign,
    values: Values,
    horizon: float,
    effects: Sequence[Effect] = (),
    which: Sequence[int] | None = None,
) -> HeldOut:
    """Windowed errors of a model on some recordings (the held-out ones if None).

    What belongs to a recording is what the others that were fitted have in common. Only window
    states are estimated there, and the zeros of phi2 where an effect depends on them; so is a size
    that each recording has of its own, within the scatter of the others', and so
    are the numbers of a noisy measured drive, within the errors of its readings: what noise made of
    a drive is no prediction of a model.
    """
    which = setting.held_out if which is None else list(which)
    others = [i for i in setting.fitted if i not in which]
    values = expected_elsewhere(values, setting, others, which)
    problem = setting.problem(horizon, which)
    # zero1 belongs to the campaign and is known from the fit; that of phi2 to the recording.
    extra, more = nuisances(list(effects), setting, which)
    unknowns = [u for u in extra if u.recording is not None]
    priors = [a for a in more if a.unknown in unknowns]
    sizes = _own_sizes(setting, values, effects, others, which)
    unknowns, priors = unknowns + [a.unknown for a in sizes], priors + sizes
    found = fit_from_readings(problem, values, unknowns, eps=setting.eps, priors=priors)
    moved, pull = put_right(setting, found, [i for i in which if i not in setting.drives])
    if moved is not setting:
        problem = moved.problem(horizon, which)
        again = fit_from_readings(problem, found.values, unknowns, eps=setting.eps, priors=priors)
        if again.cost + pull < found.cost:
            setting, found = moved, again
    return dataclasses.replace(squares(found), setting=setting)


def _own_sizes(
    setting: PreparedCampaign,
    values: Values,
    effects: Sequence[Effect],
    seen: Sequence[int],
    elsewhere: Sequence[int],
) -> list[GaussianPrior]:
    """Priors of sizes that each recording has of its own, for recordings not fitted.

    Such an effect says that nobody knows the next run's size, only about how far it may be off. So
    one run held out, whose size is by chance the baseline's, does not speak against it.
    """
    found = []
    for effect, a in ((e, a) for e in effects for a in e.amplitudes if a.per_recording):
        name = effect.qualified(a.name)
        row = setting.layout.index[name]
        spec = setting.layout.parameters[row].scaled(setting.fixed["B1"])
        told = values.table[row, _moved(values, effect, seen)]
        scatter = float(told.std(ddof=1)) if told.size > 1 else spec.typical
        scatter = max(scatter, LEAST_SCATTER * spec.typical)
        for i in _moved(values, effect, elsewhere):
            mean = float(values.table[row, i])
            sd = scatter / spec.slope(mean)
            found.append(GaussianPrior(Unknown(name, i), float(spec.to_coordinate(mean)), sd))
    return found


def squares(result: Fit) -> HeldOut:
    """Sums of squares by window and channel of a fit."""
    problem = result.problem
    r = result.linearisation.samples
    nw = r.shape[0]
    valid = result.linearisation.valid[:, :-4].reshape(nw, -1, 2)
    error = (r.reshape(nw, -1, 2) * problem.sigma[:, None]) * valid
    complete = result.linearisation.complete
    count = scatter = np.maximum(valid.sum(axis=1) - 2.0, 0.0) * complete[:, None]
    if problem.coloured:
        count, scatter = expected_squares(result)
        count, scatter = count * complete[:, None], scatter * complete[:, None]
    return HeldOut((error**2).sum(axis=1), count, result, bool(complete.all()), scatter)


def expected_squares(result: Fit) -> tuple[np.ndarray, np.ndarray]:
    """Sums of squares (w, 2) that coloured noise alone leaves, and half their variances (w, 2).

    In units of the noise's variance and its square. With the covariance C of a channel's samples,
    their derivatives X by the window's state and that state's covariance Q, what is left has the
    covariance S = C - X Q X'; its sum of squares has the mean tr S and the variance 2 tr S^2
    (Rao, 1973, Linear Statistical Inference, 2nd ed., section 4a).
    """
    problem = result.problem
    white = [dataclasses.replace(p, colour=(Colour(), Colour())) for p in problem.prepared]
    read = dataclasses.replace(problem, prepared=tuple(white))
    X = read.linearise(result.values, result.states, ()).states_jac
    J = result.linearisation.states_jac
    mean, square = np.zeros((len(X), 2)), np.zeros((len(X), 2))
    for w, r in enumerate(problem.windows.recording):
        Q, n = scaled_inverse(J[w].T @ J[w]), int(problem.windows.count[w])
        for c in np.flatnonzero(problem.prepared[r].channels):
            Xc, row = X[w, c : 2 * n : 2], problem.prepared[r].colour[c].covariance(n)
            inner = Q @ Xc.T @ Xc
            both = Q @ Xc.T @ matmul_toeplitz(row, Xc, check_finite=False)
            own = n + 2.0 * float((np.arange(n - 1, 0, -1) * row[1:] ** 2).sum())
            mean[w, c] = n - np.trace(inner)
            square[w, c] = own - 2.0 * np.trace(both) + np.trace(inner @ inner)
    return np.maximum(mean, 0.0), np.maximum(square, 0.0)


def common_horizon(setting: PreparedCampaign, horizon: float) -> float:
    """Length [s] of the held-out windows: that of a fit's, or of the longest such recording."""
    longest = max(setting.recordings[i].duration for i in setting.held_out)
    return float(min(horizon, longest))


def floor_error(setting: PreparedCampaign) -> float:
    """Relative standard error of the noise's variance, which is an estimate from the samples."""
    samples = sum(setting.recordings[i].n for i in setting.fitted)
    return max(FLOOR_ERROR, PER_SAMPLE / float(np.sqrt(samples)))


@dataclasses.dataclass(frozen=True)
class Shrink:
    """Part of the removable gap that is gone; None where there is no significant gap."""

    value: float | None
    ci95: tuple[float, float] | None
    significant: bool


def shrink(
    setting: PreparedCampaign,
    before: HeldOut,
    after: HeldOut,
    seed: int,
    least: Floor | None = None,
) -> Shrink:
    """1 - max(after^2 - floor^2, 0) / (before^2 - floor^2), windows resampled for its interval.

    `least` is the floor; None: the noise alone. A single window has no interval. All is None where
    a model could not be integrated through a window: what it does there is no small error.
    """
    if not (before.complete and after.complete):
        return Shrink(None, None, True)
    least = least or noise_alone(setting)
    noise = float(np.mean([v**2 for v in least.noise.values()]))
    floor = float(np.mean([v**2 for v in least.total.values()]))
    rng = np.random.default_rng(seed)
    n = before.squares.shape[0]
    weights = rng.multinomial(n, np.full(n, 1.0 / n), size=DRAWS)
    error = floor_error(setting)
    floors = noise * (1.0 + error * rng.standard_normal(DRAWS)) + least.draws(rng, DRAWS)
    gaps = np.array([before.mean_square(w) for w in weights]) - floors
    gap = before.mean_square() - floor
    significant = bool(np.quantile(gaps, 0.025) > 0.0)
    if not significant:
        return Shrink(None, None, False)
    rest = np.array([after.mean_square(w) for w in weights]) - floors
    part = 1.0 - np.maximum(rest, 0.0) / gaps
    value = 1.0 - max(after.mean_square() - floor, 0.0) / gap
    low, high = np.quantile(part, [0.025, 0.975])
    if n == 1:
        return Shrink(float(value), None, True)
    if n < FEW:
        level, usual = (tails.student_level(0.025, dof) for dof in (n - 1, np.inf))
        wider = level / usual * np.sqrt(n / (n - 1))
        low, high = value - wider * (value - low), min(value + wider * (high - value), 1.0)
    return Shrink(float(value), (float(min(low, value)), float(max(high, value))), True)
