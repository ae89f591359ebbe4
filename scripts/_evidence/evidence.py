"""Log evidences of hypotheses from one screen, and what noise alone would make of them.

A hypothesis puts a Gaussian prior, of mean zero and covariance P, on amplitudes whose efficient
score is s and whose information is V, in units of the noise, what the fit's unknowns and the
windows' states absorb projected out. Against "nothing" its log evidence is

    LM = 1/2 s' (V + P^-1)^-1 s - 1/2 log |I + V P|,

s and V divided by the misfit of the best model (`misfit`). Amplitudes of an effect of the catalogue
have the standard deviations t d, d by `Prior`, and its shape constants are averaged over their
grid. *Something else* is what is free in every window (`tp_jax.gap.free_torques`): a source has one
variance for all its coefficients. Scales t are averaged over a grid, or the likeliest is taken.
"""

import dataclasses
from collections.abc import Mapping

import numpy as np
from scipy.special import ndtr

from scripts._evidence.screens import Saved, Variant

SCALES = np.geomspace(1e-3, 10.0, 13)
"""Standard deviations of amplitudes over d, where d is their typical size."""

TOLD = np.geomspace(1.0, 100.0, 9)
"""The same where d is the standard error to which the recordings tell an amplitude."""

VARIANCES = np.geomspace(1e-3, 1e2, 11)
"""Variances of free coefficients, over what the mean window tells them to."""

BINS = 60
"""Into which the variances of free coefficients are put for draws, equal in the logarithm."""

LEAST = 1e-300  # of a probability: a logarithm of less there is none

ELSE = "something else"
"""Begins the name of a hypothesis that is no effect of the catalogue."""


@dataclasses.dataclass(frozen=True)
class Prior:
    """Prior of amplitudes.

    Attributes:
        name: in tables. told: whether d is what the recordings tell an amplitude to, instead of its
            typical size. likeliest: whether the likeliest scale is taken instead of the mean.
    """

    name: str
    told: bool = False
    likeliest: bool = False


PRIORS = (
    Prior("typical size, scale averaged"),
    Prior("typical size, likeliest scale", likeliest=True),
    Prior("told size, scale averaged", told=True),
)
"""The first is the one that was to be tried; the others show how much the choice matters."""


def misfit(saved: Saved) -> float:
    """Chi^2/dof that the best effect leaves, by the linearisation; one at least."""
    best = max((v.drop for v in saved.variants), default=0.0)
    return max((saved.facts["cost"] - best) / max(saved.facts["dof"], 1), 1.0)


def of_catalogue(saved: Saved, score: np.ndarray, prior: Prior) -> dict[str, np.ndarray]:
    """Log evidences (D,) of every effect.

    Args:
        saved: the screen. score: (E, D), one column for each set of scores.
        prior: of the amplitudes.
    """
    tempered = misfit(saved)
    grids: dict[str, list[np.ndarray]] = {}
    for v in saved.variants:
        found = _of_variant(saved, v, score[v.rows] / tempered, tempered, prior)
        grids.setdefault(v.effect, []).append(found)
    return {id: _log_mean(np.array(found)) for id, found in grids.items()}


def _of_variant(
    saved: Saved, v: Variant, score: np.ndarray, tempered: float, prior: Prior
) -> np.ndarray:
    """Log evidence (D,) of an effect at one set of shape constants, from its tempered scores."""
    V = saved.information[v.rows, v.rows] / tempered
    size, scales = saved.typical[v.rows], SCALES
    if prior.told:
        size, scales = 1.0 / np.sqrt(np.maximum(np.diag(V), LEAST)), TOLD
    value, vector = np.linalg.eigh(V * np.outer(size, size))
    value = np.maximum(value, 0.0)[:, None]
    square = (vector.T @ (size[:, None] * score)) ** 2
    spread = scales[:, None] ** 2
    inner = 1.0 + spread * value[:, 0]  # (scales, q)
    found = 0.5 * (spread / inner) @ square - 0.5 * np.log(inner).sum(axis=1, keepdims=True)
    if v.count == 1:
        found += _within(saved.limits[v.first], scales[:, None] * size[0], V[0, 0], score[0])
    return _over_scales(found, prior)


def _within(limits: np.ndarray, sd: np.ndarray, V: float, score: np.ndarray) -> np.ndarray | float:
    """Contribution of an amplitude's bounds: its probability within them, afterwards over before.

    Of one amplitude alone; several together count as unbounded. sd: (scales, 1); score: (D,).
    """
    if not np.isfinite(limits).any():
        return 0.0
    after = 1.0 / np.sqrt(V + 1.0 / sd**2)
    mean = -score * after**2
    low, high = limits
    then = ndtr((high - mean) / after) - ndtr((low - mean) / after)
    before = ndtr(high / sd) - ndtr(low / sd)
    return np.log(np.maximum(then, LEAST)) - np.log(np.maximum(before, LEAST))


def _over_scales(found: np.ndarray, prior: Prior) -> np.ndarray:
    """Combines log evidences (scales, D) over the scales."""
    if prior.likeliest:
        return np.maximum(found.max(axis=0), 0.0)  # a scale of zero is one of them
    return _log_mean(found)


def _log_mean(found: np.ndarray) -> np.ndarray:
    """Logarithm of the mean of what these are the logarithms of, over the first axis."""
    largest = found.max(axis=0)
    return largest + np.log(np.exp(found - largest).mean(axis=0))


def of_sources(saved: Saved, prior: Prior) -> dict[str, float]:
    """Log evidences of what is free in every window."""
    tempered, out = misfit(saved), {}
    for i, name in enumerate(saved.sources):
        value, score = (x / tempered for x in saved.of_source(i))
        found = [
            0.5 * (t * score**2 / (1.0 + t * value) - np.log1p(t * value)).sum() for t in VARIANCES
        ]
        out[f"{ELSE}: {name}"] = float(_over_scales(np.array(found)[:, None], prior)[0])
    return out


def of_noise_in_sources(
    saved: Saved, prior: Prior, level: np.ndarray, rng: np.random.Generator
) -> np.ndarray:
    """Largest log evidence (D,) of all sources where there is noise alone.

    Sources are drawn one by one, and apart from the effects of the catalogue: their largest is then
    larger than it would be together, if anything.

    Args:
        saved: the screen. prior: see `Prior`.
        level: (D,) variance of the noise over the one that evidence is tempered with.
        rng: chance.
    """
    tempered, largest = misfit(saved), np.full(level.size, -np.inf)
    for i in range(len(saved.sources)):
        value = saved.of_source(i)[0] / tempered
        value = value[value > 1e-9 * max(value.max(initial=0.0), LEAST)]
        if not value.size:
            continue
        edges = np.geomspace(value.min(), value.max() * (1.0 + 1e-9), BINS + 1)
        place = np.clip(np.searchsorted(edges, value, side="right") - 1, 0, BINS - 1)
        number = np.bincount(place, minlength=BINS)
        mean = np.bincount(place, value, BINS)[number > 0] / number[number > 0]
        number = number[number > 0]
        square = rng.chisquare(number[:, None], (number.size, level.size)) * level
        found = []
        for t in VARIANCES:
            part = (t * mean / (1.0 + t * mean)) @ square
            found.append(0.5 * part - 0.5 * np.log1p(t * value).sum())
        largest = np.maximum(largest, _over_scales(np.array(found), prior))
    return largest


def largest_of(found: Mapping[str, np.ndarray]) -> np.ndarray:
    """The largest log evidence (D,); of "nothing" it is zero."""
    return np.maximum(np.max(list(found.values()), axis=0, initial=-np.inf), 0.0)
