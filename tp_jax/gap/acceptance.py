"""Chosen causes that are offered: those that harm nothing, are probable, and have a size.

A choice is made inside the fitted data. What it came to is held against the held-out recordings,
and against its own probabilities: a cause that is less likely than not, together with those that
it cannot be told from, or whose size may be zero, is a candidate and no cause. The model is then
fitted without it; where that predicts the held-out recordings worse, it stays there, unnamed.
"""

import dataclasses
import logging

import numpy as np

from tp_jax import _tails as tails
from tp_jax.estimation.intervals import covariance
from tp_jax.estimation.layout import Values
from tp_jax.estimation.normal_equations import scaled_inverse
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.gap import detectability
from tp_jax.gap.backward import wald, without
from tp_jax.gap.choice import Choice, tied_by_gain
from tp_jax.gap.directions import Variant
from tp_jax.gap.free_run import free_runs, start_state
from tp_jax.gap.held_out import HeldOut, evaluate
from tp_jax.gap.policy import POLICY
from tp_jax.gap.probability import cause_probabilities
from tp_jax.gap.refit import Refit, polish, refit_with_sharp_friction
from tp_jax.results.diagnosis import Errors

log = logging.getLogger(__name__)

MOST_TIED = 3  # effects of a group that counts as one
LEVEL = 0.05  # at which a cause's amplitudes may all be zero


def without_harm(
    setting: PreparedCampaign, choice: Choice, horizon: float
) -> tuple[Choice, tuple[str, ...]]:
    """The choice without last causes that make the prediction of held-out data worse.

    Worse than that of the model before they were added; the first cause is held against the
    baseline (`is_worse` in the report). Returns the ids that were taken out, too.
    """
    dropped: list[str] = []
    while len(choice.final.ids) > 1:
        last = choice.final.variants[-1]
        # with the same friction as the final model, or a smoother one would count as a worse one
        before = refit_with_sharp_friction(setting, _before(setting, choice, last))
        if not _predicts_worse(setting, before, choice.final, horizon):
            break
        dropped.append(last.effect.id)
        choice = choice.ending(before)
    return choice, tuple(dropped)


def _before(setting: PreparedCampaign, choice: Choice, last: Variant) -> Refit:
    """The model to which the last cause was added, with what has been put in a cause's place since.

    A rival that took the place of an earlier cause is fitted without the last one; the model before
    it has the cause that was wrong.
    """
    others = set(choice.final.ids) - {last.effect.id}
    for r in choice.rounds:
        if r.taken is None or r.taken != last.effect.id:
            continue
        variants = r.refits[r.taken].variants[:-1]
        if {v.effect.id for v in variants} == others:
            return Refit(r.searched, variants)
    return polish(setting, without(setting, choice.final, last))


def _predicts_worse(setting: PreparedCampaign, before: Refit, after: Refit, horizon: float) -> bool:
    """True where held-out recordings are predicted worse by the second model."""

    def errors_of(result: Refit) -> Errors:
        held = evaluate(setting, result.fit.values, horizon, [v.effect for v in result.variants])
        return errors(held, free_errors(held.setting or setting, held.fit.values, horizon)[1])

    old, new = errors_of(before), errors_of(after)
    log.info("held out, %s: %s, %s: %s", "+".join(before.ids), old, "+".join(after.ids), new)
    return is_worse(old, new)


@dataclasses.dataclass(frozen=True)
class Doubts:
    """Effects that were chosen and are not named as causes: taken out of the model, or left in it
    since it would predict held-out recordings worse without them.
    """

    gone: tuple[str, ...] = ()
    unnamed: tuple[str, ...] = ()

    @property
    def every(self) -> tuple[str, ...]:
        """All of them."""
        return (*self.gone, *self.unnamed)


def without_doubt(
    setting: PreparedCampaign, choice: Choice, horizon: float
) -> tuple[Choice, dict[str, float], Doubts]:
    """The choice without causes that are not likely or whose size may be zero.

    Returns:
        The choice, the probabilities of all effects, and what was doubtful.
    """
    probabilities = cause_probabilities(choice, setting)
    gone: list[str] = []
    unnamed: list[str] = []
    while True:
        asked = [id for id in choice.causes if id not in unnamed]
        odd = [id for id in asked if not _offered(setting, choice, id, probabilities)]
        if not odd:
            break
        least = min(odd, key=lambda id: probabilities.get(id, 0.0))
        result = Refit(choice.baseline, ())
        if len(choice.causes) > 1:
            out = next(v for v in choice.final.variants if v.effect.id == least)
            result = refit_with_sharp_friction(
                setting, polish(setting, without(setting, choice.final, out))
            )
            if _predicts_worse(setting, choice.final, result, horizon):
                unnamed.append(least)
                continue
        gone.append(least)
        choice = choice.ending(result)
    if set(choice.causes) == set(unnamed):  # nothing is left to be named
        return choice.ending(Refit(choice.baseline, ())), probabilities, Doubts((*gone, *unnamed))
    return choice, probabilities, Doubts(tuple(gone), tuple(unnamed))


def _offered(
    setting: PreparedCampaign, choice: Choice, id: str, probabilities: dict[str, float]
) -> bool:
    likely = with_ties(setting, choice, id, probabilities) >= POLICY.verdict.offered
    return likely and has_size(setting, choice.final, id)


def has_size(setting: PreparedCampaign, result: Refit, id: str) -> bool:
    """True where the amplitudes of a cause are not all zero, by their joint 95 % region.

    The coefficients of a learned curve may each be uncertain where the curve is not. An effect
    whose amplitudes belong to recordings has none of the campaign: then it counts. Its shape
    constants are held: where the amplitudes are zero they mean nothing, and an amplitude that may
    be larger with another of them (a stiffer cable that slips sooner) is no smaller for that.
    """
    fit = result.fit
    effect = next(v.effect for v in result.variants if v.effect.id == id)
    names = {effect.qualified(a.name) for a in effect.amplitudes}
    own = [i for i, u in enumerate(fit.unknowns) if u.name in names and u.recording is None]
    if not own:
        return True
    free = [i for i in own if not fit.at_bound[i]]
    # an amplitude that its own upper bound holds is as far from zero as it can be
    if any(fit.at_bound[i] and fit.values.pick([fit.unknowns[i]])[0] != 0.0 for i in own):
        variant = next(v for v in result.variants if v.effect.id == id)
        return bool(wald(result, variant) > tails.chi_square_level(LEVEL, len(own)))
    if not free:
        return False
    shapes = {effect.qualified(s.name) for s in effect.shapes}
    held = fit.at_bound | np.array([u.name in shapes for u in fit.unknowns])
    every, dof = covariance(dataclasses.replace(fit, at_bound=held), setting)
    size = fit.values.pick([fit.unknowns[i] for i in free])
    square = size @ scaled_inverse(every[np.ix_(free, free)]) @ size
    # of few blocks the region is wider, as an interval is by Student's t
    wider = tails.student_level(LEVEL / 2.0, dof[free].min()) / tails.student_level(
        LEVEL / 2.0, np.inf
    )
    return bool(square > wider**2 * tails.chi_square_level(LEVEL, len(free)))


def tied(setting: PreparedCampaign, choice: Choice, no_gap: bool = False) -> list[list[str]]:
    """Groups of effects that these data do not tell apart."""
    groups = detectability.tied_groups(choice.rounds[0].screen)
    if not no_gap:
        groups += tied_by_gain(choice, setting)
    unique = []
    for g in groups:
        if g not in unique:
            unique.append(g)
    return unique


def with_ties(
    setting: PreparedCampaign, choice: Choice, id: str, probabilities: dict[str, float]
) -> float:
    """Probability of a cause together with those that it is tied with."""
    others = {x for g in tied(setting, choice) if id in g for x in g} - {id}
    shares = sorted((probabilities.get(x, 0.0) for x in others), reverse=True)
    return min(probabilities.get(id, 0.0) + sum(shares[: MOST_TIED - 1]), 1.0)


def least_probable(
    setting: PreparedCampaign, choice: Choice, probabilities: dict[str, float]
) -> float:
    """Probability of the least probable cause, each with those it is tied with."""
    every = (with_ties(setting, choice, id, probabilities) for id in choice.causes)
    return min(every, default=1.0)


def is_worse(before: Errors, after: Errors) -> bool:
    """True where held-out recordings are predicted worse, in windows or in a free run."""
    pairs = ((before.windowed, after.windowed), (before.free_run, after.free_run))
    return any(
        old is not None and (new is None or not new <= POLICY.verdict.worse * old)
        for old, new in pairs
    )


def free_errors(
    setting: PreparedCampaign, values: Values, horizon: float
) -> tuple[dict[int, np.ndarray], dict[int, np.ndarray] | None]:
    """Start states and free runs of the held-out recordings, by numbers that are theirs too."""
    which = list(setting.held_out)
    # windows of decays may have grown to most of a run, of which a free run is to be predicted
    horizon = min(horizon, setting.horizons[-1])
    starts = {i: start_state(setting, values, i, horizon) for i in which}
    if not which:
        return starts, None
    runs = free_runs(setting, values, which, np.array([starts[i] for i in which]))
    return starts, dict(zip(which, runs, strict=True))


def errors(windowed: HeldOut, free: dict[int, np.ndarray] | None) -> Errors:
    """Root mean square errors [rad] on held-out recordings, in windows and in free runs."""
    setting = windowed.fit.problem
    squares = []
    for i, y in (free or {}).items():
        p = setting.prepared[i]
        squares.append((((y - p.y)[:, p.channels]) ** 2).mean(axis=0).mean())
    value = float(np.sqrt(np.mean(squares))) if squares else None
    if value is not None and not np.isfinite(value):
        value = None
    return Errors(float(np.sqrt(windowed.mean_square())), value)
