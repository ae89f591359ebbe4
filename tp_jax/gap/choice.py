"""Choosing the causes: screen, refit of the best, cross-validation, until no structure is left."""

import dataclasses
import logging
from collections.abc import Callable

import numpy as np

from tp_jax.estimation.baseline import Setting
from tp_jax.estimation.blocks import blocks_of
from tp_jax.estimation.least_squares import Fit
from tp_jax.gap.crossvalidation import gain, left_out_cost
from tp_jax.gap.free_structure import free_structure
from tp_jax.gap.refit import Refit, freed, lengthened, polish, refit, regrown, removable, sharper
from tp_jax.gap.screen import Scored, Screen, screen
from tp_jax.gap.structure import Structure, structure_test

log = logging.getLogger(__name__)

LEVEL = 0.05  # family-wise level of the tests of structure
IN_CATALOGUE = 0.5  # of it, for structure like the catalogue's; the rest for any (`free_structure`)
SEEN = IN_CATALOGUE * LEVEL
REFITTED = (6, 4, 4)  # candidates refitted in each round
ALWAYS, SETTLED = 3, 0.05  # once so many are refitted and so little of the gap is left, stop
BY_CHANCE = 2.0  # standard deviations of a sum of squares of noise alone
EARNS = 2.5  # standard errors by which a cause must lower the left-out cost
TIE, TIE_PART = 2.0, 0.1  # tied: within two standard errors, and within a tenth of the gain
LONGER = 2  # times that windows are made three times as long, where that is done
LENGTHEN = 1.15  # chi2/dof of the final model above which it is fitted on longer windows too
MOST_PART = 0.5  # of the removable gap: a cause that takes so much is not asked for its scatter
SURELY = 5.0  # standard deviations of chance, for a gap to be one
LIKELIER, PER_AMPLITUDE = 16.0, 4.0  # twice a logarithm of likelihoods, of many candidates
NOISE_ALONE = 0.1  # of the noise's variance: three standard errors of that and more
SMOOTHING = 0.5  # of what is left: if sharper friction takes so much, it is looked at without
LITTLE = 0.5  # of the noise's variance: less is looked at with sharp friction too
LEAST_PART = 0.01  # of the removable gap that a cause must take with it, or be the last of it
CLEARLY = 64.0  # twice a logarithm of likelihoods, of a cause that takes less
ZEROS = ("zero1", "zero2")
BESIDE = 0.25  # of what it takes: what others may still promise


@dataclasses.dataclass(frozen=True)
class Round:
    """One round of the choice: what was seen from `before`, what was refitted, what was taken.

    searched: where the refits began: `before`, or that with the search's smoothing (see `sharpen`),
    which they have too. gains: id to (drop of the left-out sum of squares, its standard error).
    """

    before: Fit
    searched: Fit
    screen: Screen
    structure: Structure
    refits: dict[str, Refit]
    gains: dict[str, tuple[float, float]]
    taken: str | None


@dataclasses.dataclass(frozen=True)
class Choice:
    """The baseline, the rounds, and where they ended; baseline and end with sharp friction."""

    baseline: Fit
    rounds: tuple[Round, ...]
    final: Refit

    @property
    def causes(self) -> tuple[str, ...]:
        """Ids of the accepted causes, in order."""
        return self.final.ids

    @property
    def structure(self) -> Structure:
        """What is left unexplained, as the last round saw it."""
        return self.rounds[-1].structure


def choose(
    setting: Setting, baseline: Fit, seed: int, progress: Callable[[str, float | None], None]
) -> Choice:
    """Adds causes one by one while the data inside the fit support them.

    Held-out data are not touched here.
    """
    current = Refit(baseline, ())
    rounds: list[Round] = []
    noise_only = max(removable(baseline), 0.0)
    progress("sharpening the friction", None)
    sharp = sharp_baseline = sharper(setting, current)
    for n in range(len(REFITTED) + 1):
        progress("screening the catalogue", None)
        # Beside a cause, effects with states take programs of their own: they wait until something
        # is left that others see, as they would (what has a memory looks much like what has none).
        before, rest = current.fit, dict(skip=current.ids, states=not current.ids)
        seen = screen(before, setting, **rest)
        structure = structure_test(seen, seed)
        if structure.p < SEEN and _may_be_smoothing(before, sharp.fit):
            before = sharp.fit
            seen = screen(before, setting, **rest)
            structure = structure_test(seen, seed)
        last, small = n == len(REFITTED), False
        if current.ids and structure.p < SEEN and not last:
            seen = screen(before, setting, skip=current.ids)
            structure = structure_test(seen, seed)
            # A cause takes something worth telling with it, if it is not the last that was missing.
            promised = max((s.drop for s in seen.scored), default=0.0)
            small = promised <= LEAST_PART * noise_only
            last = small and promised <= CLEARLY
        log.info("round %d: structure p %.4g", n + 1, structure.p)
        if structure.p >= SEEN or last:
            rounds.append(Round(before, current.fit, seen, structure, {}, {}, None))
            break
        block = blocks_of(current.fit, setting)
        reference = left_out_cost(current.fit)
        refits: dict[str, Refit] = {}
        gains: dict[str, tuple[float, float]] = {}
        # Less than chance leaves of noise is not worth a search either.
        enough = max(SETTLED * noise_only, BY_CHANCE * np.sqrt(2.0 * current.fit.dof))
        ranked = _worth_refitting(setting, seen, structure)[: REFITTED[n]]
        for i, s in enumerate(ranked):
            left = min((removable(r.fit) for r in refits.values()), default=np.inf)
            if i >= ALWAYS and left < enough:
                break
            progress(f"refitting with {s.id}", i / len(ranked))
            if i == 0 and s.variant.effect.n_states:
                # The other effects with states are a burden that many fits would carry.
                current.fit.problem.programs.add({*current.ids, s.id})
            trial = refit(setting, current.fit, [*current.variants, s.variant])
            if i < ALWAYS:
                trial = freed(setting, current.fit, trial)
                if min(left, removable(trial.fit)) > enough:
                    trial = regrown(setting, current.fit, trial)
            refits[s.id] = trial
            gains[s.id] = gain(reference, left_out_cost(trial.fit), block)
        best = _likeliest(refits) if small else _most_promising(refits, gains, block)
        if small or _earned(*gains[best], noise_only, refits[best]):
            # What comes next is a look at every effect without states beside those that are in.
            programs = current.fit.problem.programs
            current.fit.problem.compile_ahead(programs.moving & {*current.ids, best}, states=False)
        progress(f"polishing {best}", None)
        polished = polish(setting, refits[best])
        refits[best] = polished
        gains[best] = drop, error = gain(reference, left_out_cost(polished.fit), block)
        taken = best if small or _earned(drop, error, noise_only, polished) else None
        if taken is not None:
            progress("sharpening the friction", None)
            keener = sharper(setting, polished)
            # Where smoothing may be what is left, the cause has to earn its place without it too.
            if small:
                taken = best if _clearly(setting, sharp, keener, seed) else None
            elif before is sharp.fit and not _earned(
                *gain(left_out_cost(before), left_out_cost(keener.fit), block),
                max(removable(before), 0.0), keener,
            ):  # fmt: skip
                taken = None
        rounds.append(Round(before, current.fit, seen, structure, refits, gains, taken))
        log.info("round %d: best %s, left-out gain %.4g +- %.3g", n + 1, best, drop, error)
        if taken is None:
            break
        current, sharp = polished, keener
    if sharp.ids and sharp.fit.chi2_dof > LENGTHEN:
        for _ in range(LONGER):
            progress("longer windows", None)
            sharp = lengthened(setting, sharp)
    return Choice(sharp_baseline.fit, tuple(rounds), sharp)


def _may_be_smoothing(before: Fit, sharp: Fit) -> bool:
    """Whether what a fit leaves may come of the friction's smoothing.

    Sharper friction then takes much of it away, or there is little. Of a model that is wrong by
    more, the smoother one is the better guide: its derivatives hold farther.
    """
    if sharp is before:  # there is nothing sharper
        return False
    left, after = removable(before), removable(sharp)
    return after < SMOOTHING * left or left < LITTLE * before.dof


def _earned(drop: float, error: float, gap: float, result: Refit) -> bool:
    """Whether a fall of the left-out sum of squares makes a cause of an effect.

    A cause that shows in a few blocks only has a large scatter and is no less real: half of a gap
    that is there beyond chance, gone from data left out, is enough; and so is a likelihood ratio
    where the effect leaves noise alone, since then it is one.

    Args:
        drop, error: fall and its standard error. gap: of the baseline, in the same unit.
        result: the fit with it.
    """
    if drop <= LEAST_PART * gap:
        return False
    chance = np.sqrt(2.0 * result.fit.dof)
    ratio = LIKELIER + PER_AMPLITUDE * _amplitudes(result)
    return bool(
        drop > EARNS * error
        or (gap > SURELY * chance and drop > MOST_PART * gap)
        or (removable(result.fit) < NOISE_ALONE * result.fit.dof and drop > ratio)
    )


def _likeliest(refits: dict[str, Refit]) -> str:
    """The refit with the smallest sum of squares, amplitudes counted.

    What is left out says less than the fit itself where an effect takes next to nothing.
    """
    return min(refits, key=lambda id: refits[id].cost + PER_AMPLITUDE * _amplitudes(refits[id]))


def _clearly(setting: Setting, before: Refit, after: Refit, seed: int) -> bool:
    """Whether an effect that takes next to nothing of a large gap is there beyond doubt.

    A law of friction that is not quite the rig's leaves something too, which other effects take in
    part. So such an effect is a cause only if it takes more than the best of many would, and what
    it leaves is noise: of its size, with no readings off, and nothing else promises much.

    Args:
        before, after: with sharp friction.
    """
    took = before.cost - after.cost
    if took <= CLEARLY + PER_AMPLITUDE * _amplitudes(after):
        return False
    if removable(after.fit) > NOISE_ALONE * after.fit.dof:
        return False
    if free_structure(setting, after.fit).p < (1.0 - IN_CATALOGUE) * LEVEL:
        return False
    seen = screen(after.fit, setting, skip=after.ids, states=False)
    promised = max((s.drop for s in seen.scored), default=0.0)
    return promised <= BESIDE * took or structure_test(seen, seed).p >= SEEN


def _amplitudes(result: Refit) -> int:
    """Of the effect that came last."""
    return len(result.variants[-1].unknowns)


def _worth_refitting(setting: Setting, seen: Screen, structure: Structure) -> list[Scored]:
    """The effects worth a refit, best first; one at least.

    Not those that could only help with the wrong sign.
    A refit knows nothing of the calibration's error. Where that is known, an effect of a sensor
    must therefore stand out in the screen, which does, or it would be credited with that error.
    """
    ranked = seen.best()
    if any(r.calibration_error for r in setting.recordings):
        sure = {s.id for s, p in zip(seen.scored, structure.by_variant, strict=True) if p < SEEN}
        ranked = [
            s for s in ranked if s.id in sure or not s.variant.effect.location.startswith("sensor")
        ]
    return [s for s in ranked if s.drop > 0.0] or ranked[:1]


def _most_promising(
    refits: dict[str, Refit], gains: dict[str, tuple[float, float]], block: np.ndarray
) -> str:
    """The refit with the largest left-out gain; among those tied with it, the simplest."""
    top = max(gains, key=lambda id: gains[id][0])
    costs = {id: left_out_cost(r.fit) for id, r in refits.items()}
    tied = []
    for id in refits:
        behind, error = gain(costs[id], costs[top], block)
        if id == top or (behind < TIE * error and behind < TIE_PART * gains[top][0]):
            tied.append(id)
    return min(tied, key=lambda id: (_amplitudes(refits[id]), -gains[id][0]))


def cause_probabilities(choice: Choice, n_samples: int) -> dict[str, float]:
    """Posterior inclusion of each effect that was looked at.

    Models: the baseline, every refit, and those only screened (with their predicted sum of
    squares), under equal prior odds, by the Bayesian information criterion; sums of squares are
    divided by the best model's misfit, so that a model that is wrong everywhere is not certain of
    details.
    """
    best = choice.final.fit
    misfit = max(best.chi2_dof, 1.0)
    penalty = np.log(max(n_samples, 2))
    # A linear prediction beyond the noise floor would be a promise nobody can keep. Sums of squares
    # over longer windows are no such floor.
    last = choice.rounds[-1].searched
    floor = best.cost if best.problem.windows.n == last.problem.windows.n else last.cost
    scores: list[tuple[frozenset[str], float]] = []
    base = frozenset[str]()
    for r in choice.rounds:
        ids = base
        cost = r.searched.cost
        if not scores:
            scores.append((ids, cost / misfit))
        q0 = _charged(r.searched)
        for s in r.screen.best():
            q = len(s.variant.unknowns)
            if s.id in r.refits:
                extra = _charged(r.refits[s.id].fit) - q0
                value = r.refits[s.id].cost / misfit + extra * penalty
            else:
                value = max(cost - s.drop, floor) / misfit + q * penalty
            offset = q0 - _charged(choice.rounds[0].searched)
            scores.append((ids | {s.id}, value + offset * penalty))
        if r.taken:
            base = base | {r.taken}
    lowest = min(v for _, v in scores)
    weights = [(ids, float(np.exp(-0.5 * (v - lowest)))) for ids, v in scores]
    total = sum(w for _, w in weights)
    names = {id for ids, _ in weights for id in ids}
    return {id: sum(w for ids, w in weights if id in ids) / total for id in names}


def _charged(fit: Fit) -> int:
    """Unknowns that cost a model likelihood; the zeros of angles have priors, which do that."""
    return sum(u.name not in ZEROS for u in fit.unknowns)


def tied_by_gain(choice: Choice, setting: Setting) -> list[list[str]]:
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
