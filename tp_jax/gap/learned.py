"""Laws that nobody wrote down, asked for where no formula of the catalogue explains the gap.

A law is a curve at a place over one quantity (`tp_jax.effects.laws`); its coefficients have a prior
that makes it smooth. All laws are screened from one linearisation, where their log evidence with
that prior ranks them: a curve of twelve numbers always takes something, and evidence charges for
what it could have taken. Where no formula leaves noise alone the best law is tried before a second
formula is. Otherwise the best are refitted once formulas have done what they can: alone and, where
none of them leaves noise alone, in addition to the causes that were found. They have to pass what a
cause has to pass: a fall of the left-out sum of squares, a confirmation by recordings left out. A
law alone that does better than the formulas replaces them: the nearest formula is not the cause.
Where formulas patch a gap between them, one law is asked for in their place, however little they
leave.
"""

import dataclasses
import logging
from collections.abc import Callable

import numpy as np

from tp_jax.effects import AnyLaw
from tp_jax.estimation.blocks import blocks_of
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.gap.choice import FURTHER, Choice, Round, choose, confirmed, looked_at, tried
from tp_jax.gap.confirmation import Confirmation
from tp_jax.gap.crossvalidation import gain, left_out_cost
from tp_jax.gap.earning import LIKELIER, PER_AMPLITUDE, earned
from tp_jax.gap.left_out import LeftOut
from tp_jax.gap.misfit import misfits
from tp_jax.gap.policy import POLICY, LearningPolicy
from tp_jax.gap.refit import (
    Refit,
    polish,
    refit,
    refit_longer_windows,
    refit_with_sharp_friction,
    removable,
)
from tp_jax.gap.screen import Scored, prior_information, screen
from tp_jax.gap.short_windows import refit_from_short_windows
from tp_jax.gap.structure import Structure, structure_test
from tp_jax.gap.visited import with_supports

log = logging.getLogger(__name__)

Progress = Callable[[str, float | None], None]


@dataclasses.dataclass(frozen=True)
class _Trial:
    """A law that was refitted: in addition to `base`, as `round` saw it; gain over `base`."""

    result: Refit
    base: Refit
    round: Round
    gain: tuple[float, float]


Trials = list[_Trial]
"""Laws that were refitted, so that none is refitted twice from the same fit."""


def choose_or_learn(
    setting: PreparedCampaign,
    baseline: Fit,
    seed: int,
    progress: Progress,
    known: Refit | None = None,
    trials: Trials | None = None,
) -> Choice:
    """The causes of `choose`, or a law that does alone what no formula does.

    A bearing that is rough in one place looks like three or four formulas together. So where none
    of the first round's leaves noise alone, and a law has more evidence than the best of them could
    have, it is refitted before a second formula is sought.

    Args:
        setting, baseline, seed, progress, known: see `choose`.
        trials: gets the laws that are refitted.
    """
    trials = [] if trials is None else trials

    def elsewhere(choice: Choice) -> Choice | None:
        r = choice.rounds[0]
        supported = with_supports(setting, r.searched)
        found = _alone(supported, r, progress, known, trials)
        return _first_accepted(supported, choice, found, seed, progress) if found else None

    asked = elsewhere if setting.layout.learned else None
    return choose(setting, baseline, seed, progress, known, asked)


def _alone(
    setting: PreparedCampaign,
    r: Round,
    progress: Progress,
    known: Refit | None,
    trials: Trials,
) -> list[_Trial]:
    """The law that leaves noise alone where every formula leaves more, or none.

    Two formulas that promise as much as the law's evidence are asked for before it: a curve over
    the column's angle can take what a drive and a spring do where the recordings went, and
    predicts others wrong.
    """
    best = min(r.refits.values(), key=lambda x: removable(x.fit), default=Refit(r.searched, ()))
    little = POLICY.learning.rest * removable(r.searched)
    if removable(best.fit) < max(_worth_asking(best.fit), little):
        return []
    if best.ids:  # a refit ends early, so that a formula that is right leaves more than noise
        best = polish(setting, best)
        if removable(best.fit) < max(_worth_asking(best.fit), little):
            return []
    least = max(_promised(r), _promised_by_two(r))
    most = POLICY.learning.part * removable(best.fit)
    nothing = Refit(r.searched, ())
    return [
        trial
        for trial in _tried(setting, r, nothing, progress, known, trials, 1, least, most)
        if _nothing_left(trial.result.fit) and removable(trial.result.fit) < most
    ]


def _promised(r: Round) -> float:
    """Log evidence that the best formula could have at most, by the screen of a round."""
    return _at_most(r, max((s.drop for s in r.screen.scored), default=0.0))


def _promised_by_two(r: Round) -> float:
    """The same of the best two together, less what is asked of a pair for being chosen."""
    pair = r.screen.pair()
    if pair is None:
        return 0.0
    a, b, drop = pair
    charge = LIKELIER + PER_AMPLITUDE * (len(a.variant.unknowns) + len(b.variant.unknowns))
    return _at_most(r, drop - charge)


def _at_most(r: Round, drop: float) -> float:
    """Log likelihood of a fall of the sum of squares, in units of what the round's fit leaves."""
    return drop / (2.0 * max(r.before.chi2_dof, 1.0))


def _worth_asking(fit: Fit, policy: LearningPolicy = POLICY.learning) -> float:
    """Sum of squares beyond the noise from which a curve could be told from chance."""
    least = policy.deviance * max(fit.chi2_dof, 1.0)
    return max(least, policy.chance * float(np.sqrt(2.0 * fit.dof)))


def learn(
    setting: PreparedCampaign,
    choice: Choice,
    seed: int,
    progress: Progress,
    known: Refit | None = None,
    trials: Trials | None = None,
) -> Choice:
    """A choice of causes, with a law where they leave structure and a law takes it.

    Args:
        setting, seed, progress, known: see `choose`. choice: which that gave.
        trials: laws that were refitted on the way to it.
    """
    trials = [] if trials is None else trials
    if not setting.layout.learned:
        return choice
    if unexplained(setting, choice):
        return _with_law(setting, choice, seed, progress, known, trials) or choice
    if _patched(choice):
        return _instead(setting, choice, seed, progress, known, trials) or choice
    return choice


def unexplained(
    setting: PreparedCampaign, choice: Choice, policy: LearningPolicy = POLICY.learning
) -> bool:
    """True where so much more than noise is left that a curve could be told from it."""
    final = choice.final.fit
    if removable(final) < _worth_asking(final, policy):
        return False
    return choice.structure.p < POLICY.structure.seen or misfits(setting, final)


def _patched(choice: Choice) -> bool:
    """True where formulas took several turns at a gap, or left structure of it.

    A law that is in no catalogue makes them do so, even where all that is left is less than chance
    leaves of the noise of so many samples.
    """
    left = choice.structure.p < POLICY.structure.seen
    return len(choice.causes) > 1 or (left and bool(choice.causes))


def _instead(
    setting: PreparedCampaign,
    choice: Choice,
    seed: int,
    progress: Progress,
    known: Refit | None,
    trials: Trials,
) -> Choice | None:
    """The choice with one law in the place of several formulas, or None.

    Only a law with more evidence than the first round's best formula could have is refitted.
    """
    r = choice.rounds[0]
    setting = with_supports(setting, r.searched)
    nothing = Refit(r.searched, ())
    found = _tried(setting, r, nothing, progress, known, trials, 1, _promised(r))
    return _first_accepted(setting, choice, found, seed, progress) if found else None


def _with_law(
    setting: PreparedCampaign,
    choice: Choice,
    seed: int,
    progress: Progress,
    known: Refit | None,
    trials: Trials,
) -> Choice | None:
    """The choice with the law that does best, or None."""
    first, last = choice.rounds[0], choice.rounds[-1]
    setting = with_supports(setting, first.searched)
    alone, many = Refit(first.searched, ()), POLICY.learning.refitted
    most = max(removable(last.searched), _worth_asking(last.searched))
    found = _tried(setting, first, alone, progress, known, trials, many, 0.0, most)
    # one that leaves no more than chance needs no formula in addition to it
    if choice.final.ids and not any(_nothing_left(t.result.fit) for t in found):
        beside = Refit(last.searched, choice.final.variants)
        found += _tried(setting, last, beside, progress, known, trials, many, 0.0, most)
    return _first_accepted(setting, choice, found, seed, progress)


def _first_accepted(
    setting: PreparedCampaign, choice: Choice, trials: list[_Trial], seed: int, progress: Progress
) -> Choice | None:
    """The choice with the best law that passes what a cause has to pass, or None."""
    last = choice.rounds[-1]
    passing = [t for t in trials if earned(*t.gain, max(removable(t.base.fit), 0.0), t.result)]
    # The formulas' windows may have been lengthened since the first round: sums of squares are
    # compared on those.
    there = [(t, _on_windows_of(setting, t.result, last.searched)) for t in passing]
    formulas = left_out_cost(last.searched)
    without: dict[int, dict[tuple, LeftOut]] = {}
    for trial, compared in sorted(there, key=lambda pair: left_out_cost(pair[1].fit).sum()):
        result, law = trial.result, trial.result.ids[-1]
        block = blocks_of(compared.fit, setting)
        better = gain(formulas, left_out_cost(compared.fit), block)
        if not earned(*better, max(removable(last.searched), 0.0), compared):
            continue
        progress(f"predicting left-out recordings: {law}", None)
        answer = (
            confirmed(setting, trial.base, result, without.setdefault(id(trial.base.fit), {}))
            if result.fit.converged
            else Confirmation(False, 0.0, 0.0, 1.0, "its fit does not come to an end")
        )
        log.info("%s: gain %.4g +- %.3g, %s", law, *trial.gain, answer)
        if answer.confirmed:
            return _taken(setting, choice, trial, answer, seed, progress)
    return None


def _on_windows_of(setting: PreparedCampaign, result: Refit, fit: Fit) -> Refit:
    """A refit, fitted again on another fit's windows where those have another length."""
    horizon = fit.problem.windows.horizon
    if horizon == result.fit.problem.windows.horizon:
        return result
    return refit(setting, result.fit, result.variants, horizon=horizon)


def _tried(
    setting: PreparedCampaign,
    r: Round,
    base: Refit,
    progress: Progress,
    known: Refit | None,
    trials: Trials,
    many: int = POLICY.learning.refitted,
    least: float = 0.0,
    most: float = np.inf,
) -> list[_Trial]:
    """The laws with the largest evidence, refitted in addition to what is in a model.

    Args:
        setting: with the laws' ranges. r: from which the laws are screened. base: what is in.
        progress, known: see `choose`. trials: laws that were refitted already; gets the new ones.
        many: laws at most. least: log evidence that they have.
        most: that one may leave beyond the noise to be polished to its end, which takes longer than
            all before it.
    """
    progress("screening laws that nobody wrote down", None)
    formulas = [*base.ids, *(e.id for e in setting.layout.effects)]
    laws_alone = screen(r.before, setting, skip=formulas, learned=True)
    ranked = sorted(laws_alone.scored, key=lambda s: -_evidence(r.before, s))[:many]
    ranked = [s for s in ranked if _evidence(r.before, s) > least]
    reference = left_out_cost(base.fit)
    out: list[_Trial] = []
    for i, s in enumerate(ranked):
        progress(f"refitting a curve: {s.id}", i / len(ranked))
        same = (t for t in trials if t.base.fit is base.fit and t.result.ids[-1] == s.id)
        earlier = next(same, None)
        trial = _refitted(setting, base, s, known) if earlier is None else earlier.result
        if not trial.fit.converged and removable(trial.fit) < most:
            trial = polish(setting, trial, FURTHER)
        found = gain(reference, left_out_cost(trial.fit), blocks_of(trial.fit, setting))
        out.append(_Trial(trial, base, r, found))
        log.info(
            "%s: log evidence %.4g, left-out gain %.4g +- %.3g",
            "+".join(trial.ids),
            _evidence(r.before, s),
            *found,
        )
        if _nothing_left(trial.fit):
            break
    trials += out
    return out


def _refitted(setting: PreparedCampaign, base: Refit, s: Scored, known: Refit | None) -> Refit:
    """A law in addition to what is in a model, refitted from short windows too, and polished."""
    base.fit.problem.programs.add({*base.ids, AnyLaw.id})
    trial = tried(setting, base, s, known)
    if not _nothing_left(trial.fit):
        trial = refit_from_short_windows(setting, base.fit, trial)
    return polish(setting, trial)


def _nothing_left(fit: Fit) -> bool:
    """True where a fit leaves no more than chance leaves of noise."""
    return removable(fit) < POLICY.learning.chance * np.sqrt(2.0 * fit.dof)


def log_evidence(score: np.ndarray, V: np.ndarray, prior: np.ndarray) -> float:
    """Computes ½ s'(V + P)⁻¹ s − ½ log|1 + V P⁻¹|: columns with Gaussian amplitudes against none.

    Args:
        score, V: (q,), (q, q) efficient score and information, in units of the noise.
        prior: (q, q) diagonal; information P that is there before any data.
    """
    scale = 1.0 / np.sqrt(np.diag(prior))
    # in units of the prior's standard deviations, in which the prior is a unit matrix
    value, vector = np.linalg.eigh(V * np.outer(scale, scale))
    value = np.maximum(value, 0.0)
    along = vector.T @ (scale * score)
    return float(0.5 * np.sum(along**2 / (value + 1.0) - np.log1p(value)))


def _evidence(fit: Fit, s: Scored) -> float:
    """The same of a law that was screened.

    All is divided by the fit's misfit, which is that of a model without the law and so too large:
    evidence is then too small for all laws alike.
    """
    misfit = max(fit.chi2_dof, 1.0)
    score = s.blocks.sum(axis=0)
    return log_evidence(score / misfit, s.V / misfit, prior_information(fit, s.variant))


def _taken(
    setting: PreparedCampaign,
    choice: Choice,
    trial: _Trial,
    answer: Confirmation,
    seed: int,
    progress: Progress,
) -> Choice:
    """The choice in which a law is the last cause."""
    law, polished = trial.result.ids[-1], trial.result
    if polished.fit.chi2_dof < POLICY.horizon.below:
        progress("longer windows", None)
        polished = refit_longer_windows(setting, polished, POLICY.horizon.factor)
    progress("sharpening the friction", None)
    sharp = refit_with_sharp_friction(setting, polished)
    r, beside = trial.round, trial.base.ids
    both = screen(r.before, setting, skip=beside, states=not beside, learned=True)
    # p values of laws in addition to those of the catalogue; that of the round stays what it was
    told = structure_test(both, seed).by_variant
    r = dataclasses.replace(
        r,
        screen=both,
        refits={**r.refits, law: trial.result},
        structure=dataclasses.replace(r.structure, by_variant=told),
        gains={**r.gains, law: trial.gain},
        confirmations={**r.confirmations, law: answer},
        taken=law,
    )
    # a law alone is what the first round should have found; one added to causes is a round more
    earlier = choice.rounds[:-1] if trial.base.ids else ()
    if _nothing_left(polished.fit):
        # The whole catalogue in addition to a law is a program of its own, which takes minutes to
        # compile, and what is left is chance by the test of the whole; the test without candidates
        # follows. Nothing is a hypothesis there: what the law took would count as its own twice.
        before, seen = polished.fit, dataclasses.replace(both, scored=())
        structure = Structure(1.0, np.ones(0), 0)
    else:
        before, seen, structure = looked_at(setting, polished, sharp, seed)
    end = Round(before, polished.fit, seen, structure, {}, {}, None)
    return dataclasses.replace(choice, rounds=(*earlier, r, end), final=sharp)
