"""Choosing the causes: screen, refit of the best, cross-validation, until no structure is left."""

import dataclasses
import logging
from collections.abc import Callable

import numpy as np

from tp_jax.estimation.blocks import blocks_of
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.gap.backward import Tested, pruned, replaced
from tp_jax.gap.confirmation import Confirmation, confirm
from tp_jax.gap.crossvalidation import gain, left_out_cost
from tp_jax.gap.earning import (
    CLEARLY,
    LEAST_PART,
    NOISE_ALONE,
    TIE,
    TIE_PART,
    clearly,
    earned,
    likeliest,
    most_promising,
)
from tp_jax.gap.frequency import tuned
from tp_jax.gap.left_out import LeftOut, groups, largest_share, left_out, shares
from tp_jax.gap.misfit import misfits
from tp_jax.gap.policy import POLICY
from tp_jax.gap.refit import (
    Refit,
    polish,
    refit,
    refit_longer_windows,
    refit_shape_constants,
    refit_with_sharp_friction,
    removable,
)
from tp_jax.gap.screen import Scored, Screen, screen
from tp_jax.gap.short_windows import refit_from_short_windows
from tp_jax.gap.structure import Structure, structure_test
from tp_jax.gap.worth_refitting import known_first, with_pair, worth_refitting

log = logging.getLogger(__name__)

REFITTED = (6, 4, 4)  # candidates refitted in each round
ALWAYS, SETTLED = 3, 0.05  # once so many are refitted and so little of the gap is left, stop
BY_CHANCE = 2.0  # standard deviations of a sum of squares of noise alone
LONGER = 2  # times that windows are made three times as long, where that is done
LENGTHEN = 1.15  # chi2/dof of the final model above which it is fitted on longer windows too
SMOOTHING = 0.5  # of what is left: if sharper friction takes so much, it is looked at without
LITTLE = 0.5  # of the noise's variance: less is looked at with sharp friction too
FURTHER = 60  # steps more of a polish that has not ended
ALTERNATIVES = 3  # effects that are asked for confirmation in one round
#: samples above which a model beside causes that is polished, confirmed and sharpened has programs
#: of its own, and those above which each refit has. To compile one takes 5 CPU s, and two or three
#: are needed; a pass over 15,000 samples by the program that all share takes .14 s instead of .04.
#: A refit makes some twenty passes, all that comes after it a hundred. (On a rig of 60,000 samples
#: that stayed unexplained three quarters of the time went into programs of single refits.)
OWN_PROGRAM, EACH_ITS_OWN = 50_000, 150_000


@dataclasses.dataclass(frozen=True)
class Round:
    """One round of the choice: what was seen from `before`, what was refitted, what was taken.

    searched: where the refits began: `before`, or that with the search's smoothing (see `sharpen`),
    which they have too. gains: id to (drop of the left-out sum of squares, its standard error).
    confirmations: id to what recordings left out say of it, for those that were asked for.
    """

    before: Fit
    searched: Fit
    screen: Screen
    structure: Structure
    refits: dict[str, Refit]
    gains: dict[str, tuple[float, float]]
    taken: str | None
    confirmations: dict[str, Confirmation] = dataclasses.field(default_factory=dict)


@dataclasses.dataclass(frozen=True)
class Choice:
    """The baseline, the rounds, and where they ended; baseline and end with sharp friction.

    tested: causes that were compared with others in their place, once there were several. looks:
    window lengths over which anything was looked for until then.
    """

    baseline: Fit
    rounds: tuple[Round, ...]
    final: Refit
    tested: tuple[Tested, ...] = ()
    looks: int = 1

    @property
    def causes(self) -> tuple[str, ...]:
        """Ids of the accepted causes, in order."""
        return self.final.ids

    @property
    def structure(self) -> Structure:
        """Returns what is left unexplained, as the last round saw it."""
        return self.rounds[-1].structure

    def standing_for(self, taken: str) -> str:
        """The cause that stands where an effect was taken: itself, or the one that replaced it."""
        if taken in self.causes:
            return taken
        return next((t.cause for t in self.tested if t.rival == taken), taken)

    def ending(self, final: Refit) -> "Choice":
        """The choice that ends with another model; rounds of causes not in it took nothing."""
        rounds = tuple(
            dataclasses.replace(r, taken=None)
            if r.taken is not None and self.standing_for(r.taken) not in final.ids
            else r
            for r in self.rounds
        )
        return dataclasses.replace(self, rounds=rounds, final=final)


def choose(
    setting: PreparedCampaign,
    baseline: Fit,
    seed: int,
    progress: Callable[[str, float | None], None],
    known: Refit | None = None,
    elsewhere: Callable[[Choice], Choice | None] | None = None,
    so_far: Choice | None = None,
) -> Choice:
    """Adds causes one by one while the data inside the fit support them.

    Held-out data are not touched here.

    Args:
        setting, baseline, seed, progress: see `diagnose`.
        known: causes as they were found under another noise. They are judged anew beside their
            rivals; only the way to their optimum is not gone a second time.
        elsewhere: asked once the first round's refits are done, of the choice so far; the choice
            to end with, where something else than effects of the catalogue is the cause.
        so_far: a choice of causes, with sharp friction, to which others are added.
    """
    noise_only = max(removable(baseline), 0.0)
    if so_far is None:
        progress("sharpening the friction", None)
        current = Refit(baseline, ())
        sharp = refit_with_sharp_friction(setting, current)
        so_far = Choice(sharp.fit, (), sharp)
    else:
        current = sharp = so_far.final
    rounds, tested = [*so_far.rounds], [*so_far.tested]
    for n in range(len(current.ids), len(REFITTED) + 1):
        progress("screening the catalogue", None)
        # In addition to a cause, effects with states take programs of their own: they wait until
        # something is left that others see, as they would (what has a memory looks much like what
        # has none).
        before, seen, structure = looked_at(setting, current, sharp, seed)
        last, small = n == len(REFITTED), False
        if current.ids and structure.p < POLICY.structure.seen and not last:
            seen = screen(before, setting, skip=current.ids)
            structure = structure_test(seen, seed)
            # A cause takes something worth telling with it, if it is not the last that was missing.
            # Of a large gap a hundredth may still be far above the noise: then it is no small one.
            promised = max((s.drop for s in seen.scored), default=0.0)
            near = removable(before) < NOISE_ALONE * before.dof
            small = near and promised <= LEAST_PART * noise_only
            last = small and promised <= CLEARLY
        log.info("round %d: structure p %.4g", n + 1, structure.p)
        nothing = structure.p >= POLICY.structure.seen
        if nothing and n == 0:
            # A large misfit scatters the blocks too, and the test sees less for it. What the others
            # reject is searched as well.
            nothing = not misfits(setting, before)
        if nothing or last:
            rounds.append(Round(before, current.fit, seen, structure, {}, {}, None))
            break
        samples = current.fit.problem.windows.count.sum()
        block = blocks_of(current.fit, setting)
        reference = left_out_cost(current.fit)
        refits: dict[str, Refit] = {}
        gains: dict[str, tuple[float, float]] = {}
        # Less than chance leaves of noise is not worth a search either.
        left_now = max(removable(current.fit), 0.0)
        enough = max(SETTLED * left_now, BY_CHANCE * np.sqrt(2.0 * current.fit.dof))
        seen = tuned(setting, before, seen)
        ranked = worth_refitting(setting, seen, structure)[: REFITTED[n]]
        ranked = known_first(seen, with_pair(seen, ranked), current, known)
        for i, s in enumerate(ranked):
            left = min((removable(r.fit) for r in refits.values()), default=np.inf)
            if i >= ALWAYS and left < enough:
                break
            progress(f"refitting: {s.id}, {i + 1} of {len(ranked)}", i / len(ranked))
            many = samples > EACH_ITS_OWN
            if (current.ids and many) or (i == 0 and s.variant.effect.n_states):
                # The other effects are a burden that many fits would carry: in addition to what is
                # in, all without states share a program, of four times the time; so do those with
                # states.
                current.fit.problem.programs.add({*current.ids, s.id})
            trial = tried(setting, current, s, known)
            if i < ALWAYS:
                trial = refit_shape_constants(setting, current.fit, trial)
                if min(left, removable(trial.fit)) > enough:
                    trial = refit_from_short_windows(setting, current.fit, trial)
            refits[s.id] = trial
            gains[s.id] = gain(reference, left_out_cost(trial.fit), block)
        if n == 0 and elsewhere is not None:
            r = Round(before, current.fit, seen, structure, refits, gains, None)
            other = elsewhere(Choice(so_far.baseline, (r,), sharp))
            if other is not None:
                return other
        if not refits:  # all that apply were ruled out by hand
            rounds.append(Round(before, current.fit, seen, structure, refits, gains, None))
            break
        best = likeliest(refits) if small else most_promising(refits, gains, block)
        if small or earned(*gains[best], left_now, refits[best]):
            # What comes next is a look at every effect without states in addition to those
            # that are in.
            programs = current.fit.problem.programs
            current.fit.problem.compile_ahead(programs.moving & {*current.ids, best}, states=False)
        taken, polished = None, current
        sharp_candidate: Refit | None = None
        confirmations: dict[str, Confirmation] = {}
        without: dict[tuple, LeftOut] = {}
        while taken is None and len(confirmations) < ALTERNATIVES:
            progress(f"polishing: {best}", None)
            if current.ids and samples > OWN_PROGRAM:
                current.fit.problem.programs.add({*current.ids, best})
            polished = polish(setting, refits[best])
            if not polished.fit.converged:
                polished = polish(setting, polished, FURTHER)
            refits[best] = polished
            gains[best] = drop, error = gain(reference, left_out_cost(polished.fit), block)
            log.info("round %d: best %s, left-out gain %.4g +- %.3g", n + 1, best, drop, error)
            if not (small or earned(drop, error, left_now, polished)):
                break
            progress(f"predicting left-out recordings: {best}", None)
            if polished.fit.converged:
                confirmations[best] = confirmed(setting, current, polished, without)
            else:  # where it would end nobody knows
                reason = "its fit does not come to an end"
                confirmations[best] = Confirmation(False, 0.0, 0.0, 1.0, reason)
            if confirmations[best].confirmed:
                # Where smoothing may be what is left, the cause has to earn its place without it
                # too. That takes as long as all before it, so it comes last.
                sharp_candidate = None
                if small or before is sharp.fit:
                    progress("sharpening the friction", None)
                    sharp_candidate = refit_with_sharp_friction(setting, polished)
                    if small and not clearly(setting, sharp, sharp_candidate, seed):
                        break
                    if not small and not earned(
                        *gain(left_out_cost(before), left_out_cost(sharp_candidate.fit), block),
                        max(removable(before), 0.0),
                        sharp_candidate,
                    ):
                        break
                taken = best
                break
            others = {id: r for id, r in refits.items() if id not in confirmations}
            if not others:
                break
            best = most_promising(others, {id: gains[id] for id in others}, block)
        rounds.append(
            Round(before, current.fit, seen, structure, refits, gains, taken, confirmations)
        )
        if taken is None:
            break
        if len(polished.variants) > 1:
            progress("trying to do without a cause", None)
            checked = pruned(setting, polished, POLICY.backward)
            refitted = [r.refits for r in rounds]
            checked, pairs = replaced(setting, checked, refitted, POLICY.backward)
            tested += pairs
            if checked is not polished:
                polished, sharp_candidate = polish(setting, checked), None
        if polished.fit.chi2_dof < POLICY.horizon.below:
            progress("longer windows", None)
            longer = refit_longer_windows(setting, polished, POLICY.horizon.factor)
            if longer is not polished:
                polished, sharp_candidate = longer, None
        if sharp_candidate is None:
            progress("sharpening the friction", None)
            sharp_candidate = refit_with_sharp_friction(setting, polished)
        current, sharp = polished, sharp_candidate
    longer = lengthened(setting, sharp, progress)
    fewer = longer if longer is sharp else pruned(setting, longer, POLICY.backward)
    choice = Choice(so_far.baseline, tuple(rounds), longer, tuple(tested))
    if fewer is longer:
        return choice
    # A cause has stood in for another that shows over long times: once it is gone there, the other
    # is looked for in its place (drag, on the real arm that swings freely).
    begun = choice.ending(polish(setting, fewer))
    return choose(setting, baseline, seed, progress, known, so_far=begun)


def lengthened(
    setting: PreparedCampaign, sharp: Refit, progress: Callable[[str, float | None], None]
) -> Refit:
    """The final model fitted on longer windows, where something of the gap is left."""
    if sharp.ids and sharp.fit.chi2_dof > LENGTHEN:
        for _ in range(LONGER):
            progress("longer windows", None)
            sharp = refit_longer_windows(setting, sharp)
    return sharp


def looked_at(
    setting: PreparedCampaign, current: Refit, sharp: Refit, seed: int
) -> tuple[Fit, Screen, Structure]:
    """A fit that is looked at for what it leaves, its screen, and whether anything is there.

    Where the friction's smoothing may be what is left, there is something only if both the fit with
    and the one without it say so. Mostly the sharp one is the one that does not, so it is first.
    """
    doubtful = _may_be_smoothing(current.fit, sharp.fit)
    first = sharp.fit if doubtful else current.fit
    seen = screen(first, setting, current.ids, states=not current.ids)
    structure = structure_test(seen, seed)
    if doubtful and structure.p < POLICY.structure.seen:
        smooth = screen(current.fit, setting, current.ids, states=not current.ids)
        other = structure_test(smooth, seed)
        if other.p >= POLICY.structure.seen:
            return current.fit, smooth, other
    return first, seen, structure


def tried(setting: PreparedCampaign, current: Refit, s: Scored, known: Refit | None) -> Refit:
    """A refit with one more effect, from the optimum of these effects where it is known."""
    if known is None or {*current.ids, s.id} != set(known.ids):
        return refit(setting, current.fit, [*current.variants, s.variant])
    found = {v.effect.id: v for v in known.variants}
    both = [found[id] for id in (*current.ids, s.id)]
    return refit(setting, current.fit, both, known=known.fit)


def confirmed(
    setting: PreparedCampaign, current: Refit, trial: Refit, without: dict[tuple, LeftOut]
) -> Confirmation:
    """Returns what recordings left out say of the effect that came last.

    Args:
        setting, current, trial: the campaign, and the fits without and with it.
        without: errors of the former where they are known already.
    """
    new = trial.variants[-1]
    policy = POLICY.confirm
    found = Confirmation(False, 0.0, 0.0, 1.0, "the recordings are too few or too short")
    own = any(u.recording is not None for u in new.unknowns)
    for within in (True,) if own else (False, True):
        group = groups(setting, current.fit, POLICY.folds, within)
        if int(group.max()) + 1 < POLICY.folds.fewest:
            continue
        if within and not own and largest_share(trial) < policy.concentrated:
            continue  # several recordings tell of it, and they have spoken
        alone = np.flatnonzero(shares(trial, group) > policy.concentrated).tolist()
        key = (within, *alone)
        if key not in without:
            without[key] = left_out(setting, current, group, policy, alone)
        found = confirm(
            without[key],
            left_out(setting, trial, group, policy, alone),
            trial.fit.chi2_dof,
            len(new.effect.amplitudes),
            policy,
        )
        log.info("%s: %s", new.effect.id, found)
        if found.confirmed:
            break
    return found


def _may_be_smoothing(before: Fit, sharp: Fit) -> bool:
    """True where what a fit leaves may come of the friction's smoothing.

    Sharper friction then takes much of it away, or there is little. Of a model that is wrong by
    more, the smoother one is the better guide: its derivatives hold farther.
    """
    if sharp is before:  # there is nothing sharper
        return False
    left, after = removable(before), removable(sharp)
    return after < SMOOTHING * left or left < LITTLE * before.dof


def tied_by_gain(choice: Choice, setting: PreparedCampaign) -> list[list[str]]:
    """Effects whose left-out gain does not differ beyond its error from that of a cause."""
    groups = []
    for r in choice.rounds:
        if r.taken is None:
            continue
        block = blocks_of(r.searched, setting)
        best = left_out_cost(r.refits[r.taken].fit)
        for id, trial in r.refits.items():
            behind, error = gain(left_out_cost(trial.fit), best, block)
            if id != r.taken and behind < TIE * error and behind < TIE_PART * r.gains[r.taken][0]:
                groups.append(sorted([id, r.taken]))
    return groups
