"""Restricted likelihood of a colour: what residuals say of noise, freed of all that goes with the
motion.

The residuals of every recording lose the harmonics of a commanded drive's phase, or polynomials of
the states where there is none, and what their windows' states follow. The number of directions lost
is the same under every colour, or it would decide between them.

Source: Patterson, Thompson (1971), Biometrika 58, 545-554.
"""

import copy
import itertools
from collections.abc import Sequence

import numpy as np

from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.noise_levels import CHANNELS
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.estimation.residual_noise_policy import ResidualNoisePolicy
from tp_jax.recordings import Colour
from tp_jax.recordings.noise import quantum

SPANNED = 1e-3
"""Part of the largest derivative, and of the largest singular value, that spans a direction."""

FOLLOWED = 1e-4
"""Part of the largest singular value from which a direction of what goes with the motion counts."""


class Rest:
    """Residuals of one channel in some recordings, without what goes with the motion."""

    def __init__(
        self,
        setting: PreparedCampaign,
        fit: Fit,
        group: Sequence[int],
        c: int,
        policy: ResidualNoisePolicy,
    ):
        lin, w = fit.linearisation, fit.problem.windows
        n = lin.n_samples
        rows = slice(c, 2 * n, 2)
        self.parts, self.recordings = [], []
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
            self.recordings.append(i)
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
        square, free = self.squares(colour)
        apart = np.abs(square / np.average(square, weights=free) - 1.0)
        return bool(np.all(apart <= policy.apart + 3.0 * np.sqrt(2.0 / free)))

    def squares(self, colour: Colour) -> tuple[np.ndarray, np.ndarray]:
        """Mean square (p,) under a colour in each of `recordings`, of so many (p,) free samples."""
        square, free = np.zeros(len(self.parts)), np.zeros(len(self.parts))
        for i, (table, inside) in enumerate(self.parts):
            rss, _, (_, used) = _projected(colour.whiten(table, axis=1) * inside[:, :, None])
            free[i] = max(float(inside.sum()) - used, 1.0)
            square[i] = rss / free[i]
        return square, free

    def thinned(self, most: int) -> "Rest":
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
