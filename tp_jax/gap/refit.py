"""Nonlinear refits: the baseline with one or more effects added."""

import dataclasses
import logging
from collections.abc import Collection, Sequence

import numpy as np

from tp_jax.effects import Effect
from tp_jax.estimation.fitted import Fit, parameter
from tp_jax.estimation.layout import Unknown, Values
from tp_jax.estimation.normal_equations import efficient_inverse
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.estimation.priors import GaussianPrior
from tp_jax.estimation.problem import Problem
from tp_jax.estimation.sharpen import fit_with_sharp_friction
from tp_jax.estimation.variable_projection import fit
from tp_jax.estimation.window_states import warm_start_states
from tp_jax.gap.directions import Variant
from tp_jax.gap.screen import WIDE

log = logging.getLogger(__name__)

COARSE, COARSE_PART = 0.2, 1e-3
BEYOND_CHANCE = 3.0  # standard deviations of a sum of squares of noise alone
VALLEY = 50.0  # of a sum of squares: to know which way a number goes that is held
POLISHED = 1.0  # of a sum of squares; sharper friction comes after it, fitted to a fiftieth
MOST_SAMPLES = 1000  # of a window; longer ones take a program of their own for little
#: rad; how far the zero of phi1 may be from where the column seems to rest. With a tilt and hardly
#: a spring it turns with the tilt's two amplitudes, exactly, and a zero without end makes a
#: constant torque of a spring that vanishes: no fit would end. So it has a bound besides.
ZERO1_SD = 0.1
ZERO1_MOST = 3.0  # standard deviations
ANY_ZERO1_SD = 1.0  # rad; where nothing says at which reading the column rests, as with a drive
ZERO2_SD = 0.3  # rad; where the rider is put is not known, but it is read as about zero


@dataclasses.dataclass(frozen=True)
class Refit:
    """A fit with effects. variants: the effects with the shape constants that were found."""

    fit: Fit
    variants: tuple[Variant, ...]

    @property
    def ids(self) -> tuple[str, ...]:
        """Ids of the effects."""
        return tuple(v.effect.id for v in self.variants)

    @property
    def cost(self) -> float:
        """Sum of squares."""
        return self.fit.cost


def nuisances(
    effects: Sequence[Effect],
    setting: PreparedCampaign,
    recordings: Sequence[int],
    zero1: float = 0.0,
) -> tuple[list[Unknown], list[GaussianPrior]]:
    """Zeros of the angles, which matter only where an effect depends on an angle itself.

    That of phi2 is one per recording; that of phi1 is one per campaign, and where the motor stands
    or its sine is commanded it is an unknown of the baseline already. Where every drive is measured
    nothing says where the spring is relaxed either.

    Args:
        effects: of a model. setting: the campaign. recordings: those that are fitted.
        zero1: where a fit without the effects has the zero of phi1 [rad].
    """
    index, specs = setting.layout.index, setting.layout.parameters
    unknowns: list[Unknown] = []
    priors: list[GaussianPrior] = []
    known = Unknown("zero1") in setting.unknowns()
    if any(e.uses_phi1 for e in effects) or (effects and known):
        spec = specs[index["zero1"]]
        unknowns.append(Unknown("zero1"))
        centre, sd = float(spec.to_coordinate(zero1)), ZERO1_SD if known else ANY_ZERO1_SD
        priors.append(GaussianPrior(unknowns[-1], centre, sd / spec.slope(zero1)))
    if any(e.uses_winding for e in effects) and not known:
        sd = ANY_ZERO1_SD / specs[index["preload"]].typical
        unknowns.append(Unknown("preload"))
        priors.append(GaussianPrior(unknowns[-1], 0.0, sd))
    if any(e.uses_phi2 for e in effects):
        mine = [Unknown("zero2", i) for i in recordings]
        unknowns += mine
        priors += [GaussianPrior(u, 0.0, ZERO2_SD / specs[index["zero2"]].typical) for u in mine]
    return unknowns, priors


def refit(
    setting: PreparedCampaign,
    before: Fit,
    variants: Sequence[Variant],
    *,
    horizon: float | None = None,
    max_iterations: int = 20,
    known: Fit | None = None,
) -> Refit:
    """Adds effects to a fit and finds the new optimum, coarsely: only the best is polished.

    Args:
        setting: the campaign.
        before: fit to start from (its unknowns are kept).
        variants: effects with shape constants, those of `before` included.
        horizon: window length; that of `before` if None.
        max_iterations: see `variable_projection.fit`.
        known: a fit with all of these effects, under another noise say, whose numbers are the
            start; the friction's smoothing is that of `before`.
    """
    unknowns = list(setting.unknowns())
    values = before.values
    if known is not None:
        smoothing = [setting.layout.index[name] for name in ("eps1", "eps2")]
        values = known.values.replace({})
        values.table[smoothing] = before.values.table[smoothing]
    zero1 = _resting(before)
    extra, priors = nuisances([v.effect for v in variants], setting, setting.fitted, zero1)
    for v in variants:
        values = values.replace(v.settings)
        unknowns += [u for u in v.unknowns if u not in unknowns]
    priors += [GaussianPrior(u, 0.0, WIDE) for v in variants for u in v.unknowns]
    unknowns += [u for u in extra if u not in unknowns]
    problem, states = before.problem, before.states
    if horizon is not None and horizon != problem.windows.horizon:
        problem = setting.problem(horizon)
        states = warm_start_states(before, problem)
    if known is not None:
        states = warm_start_states(known, problem)
    base = [a for a in setting.priors() if a.unknown in unknowns]
    base = [a for a in base if a.unknown not in {b.unknown for b in priors}]
    result = fit(
        problem,
        values,
        unknowns,
        states,
        bounds=setting.bounds | _of_zero(problem, priors),
        priors=[*base, *priors],
        max_iterations=max_iterations,
        tolerance=coarse_drop(before),
        relative=0.0,
    )
    log.info(
        "%s: chi2/dof %.4g, %s",
        "+".join(v.effect.id for v in variants),
        result.chi2_dof,
        result.message,
    )
    return Refit(result, tuple(variants))


def _of_zero(problem: Problem, priors: Sequence[GaussianPrior]) -> dict[str, tuple[float, float]]:
    """Bounds of the zero of phi1 [rad], where it has a prior."""
    out = {}
    for a in priors:
        spec = parameter(problem, a.unknown)
        if a.unknown == Unknown("zero1") and a.sd < 2.0 * ZERO1_SD / spec.slope(0.0):
            ends = a.mean - ZERO1_MOST * a.sd, a.mean + ZERO1_MOST * a.sd
            out["zero1"] = tuple(float(spec.from_coordinate(x)) for x in ends)
    return out


def _resting(before: Fit) -> float:
    """The zero of phi1 of a fit [rad]; where it has a prior already, that prior's centre."""
    for a in before.priors:
        if a.unknown == Unknown("zero1"):
            return float(parameter(before.problem, a.unknown).from_coordinate(a.mean))
    return before.values.get("zero1")


def coarse_drop(before: Fit) -> float:
    """Drop of the sum of squares that is not worth another step, of what may be removed at all.

    In parts of the whole sum, which is mostly noise, a small effect would not be worth the first.
    """
    return max(COARSE, COARSE_PART * removable(before))


def refit_shape_constants(
    setting: PreparedCampaign, before: Fit, trial: Refit, max_iterations: int = 15
) -> Refit:
    """The same effects, their continuous shape constants fitted too.

    A point of the grid may be far enough from the truth to look like another effect. So may the
    shape of an earlier cause, which was found without the last one and took part of it: fitted
    again beside some candidates and not beside others, it would decide between them.
    """
    if not any(s.continuous for v in trial.variants for s in v.effect.shapes):
        return trial
    unknowns, bounds = with_shapes(setting, trial)
    found = _again(
        trial.fit, trial.fit.values, unknowns, bounds, max_iterations, coarse_drop(before)
    )
    return _with_its_shapes(trial, found)


def with_shapes(setting: PreparedCampaign, result: Refit) -> tuple[list[Unknown], dict]:
    """Unknowns and bounds with the continuous shape constants of all effects.

    Of those before the last too: they were found beside less.
    """
    unknowns = list(result.fit.unknowns)
    bounds = setting.bounds | _of_zero(result.fit.problem, result.fit.priors)
    for effect in (v.effect for v in result.variants):
        for s in (s for s in effect.shapes if s.continuous):
            name = effect.qualified(s.name)
            bounds[name] = (min(s.grid) / 3.0, max(s.grid) * 3.0)
            if Unknown(name) not in unknowns:
                unknowns.append(Unknown(name))
    return unknowns, bounds


def _at(variant: Variant, values: Values) -> Variant:
    """A variant with the shape constants of a fit."""
    names = sorted(s.name for s in variant.effect.shapes)
    shapes = tuple((n, values.get(variant.effect.qualified(n))) for n in names)
    return dataclasses.replace(variant, shapes=shapes)


def inside_bounds(problem: Problem, stuck: Sequence[Unknown]) -> dict[str, float]:
    """Values off their bounds, for parameters that end at zero."""
    stuck = [u for u in stuck if parameter(problem, u).transform == "identity"]
    return {u.name: 0.2 * parameter(problem, u).typical for u in stuck}


def polish(setting: PreparedCampaign, result: Refit, max_iterations: int = 25) -> Refit:
    """Takes a refit to its optimum: shape constants freed, parameters moved off their bounds.

    Continuous shape constants of all effects are freed from where they were left. A parameter that
    a wrong model had pushed to a bound may be held there by another. So it is held inside while the
    others find their place; only if it would go further in from there than back to the bound, it is
    freed, and kept where it does better. Where no more is left than chance leaves, there is nothing
    to be found.
    """
    before = result.fit
    unknowns, bounds = with_shapes(setting, result)
    done = _again(before, before.values, unknowns, bounds, max_iterations)
    stuck = [u for u, b in zip(done.unknowns, done.at_bound, strict=True) if b]
    inside = inside_bounds(done.problem, stuck)
    if inside and removable(done) > BEYOND_CHANCE * np.sqrt(2.0 * done.dof):
        others = [u for u in unknowns if u.name not in inside]
        held = fit(
            done.problem,
            done.values.replace(inside),
            others,
            done.states,
            bounds=bounds,
            priors=[a for a in done.priors if a.unknown in others],
            max_iterations=max_iterations,
            tolerance=VALLEY,
            relative=0.0,
        )
        whole = dataclasses.replace(held, priors=done.priors)
        there = _again(whole, held.values, unknowns, bounds, 0)
        if np.isfinite(there.cost) and _falls_inwards(there, inside):
            trial = _again(there, there.values, unknowns, bounds, max_iterations)
            done = trial if trial.cost < done.cost else done
    return _with_its_shapes(result, done)


def _falls_inwards(there: Fit, held: Collection[str]) -> bool:
    """True where the sum of squares falls as a number that was held grows, the others following."""
    told = there.eliminated.summed()
    g, H = told.g, told.H
    mine = np.array([u.name in held for u in there.unknowns])
    follow = efficient_inverse(H[np.ix_(~mine, ~mine)]) @ g[~mine]
    return bool(np.any(g[mine] - H[np.ix_(mine, ~mine)] @ follow < 0.0))


def _again(
    before: Fit, values: Values, unknowns, bounds, max_iterations: int, tolerance: float = POLISHED
) -> Fit:
    return fit(
        before.problem,
        values,
        unknowns,
        before.states,
        bounds=bounds,
        priors=before.priors,
        max_iterations=max_iterations,
        tolerance=tolerance,
        relative=1e-7,
        kinks=True,
    )


def refit_with_sharp_friction(setting: PreparedCampaign, result: Refit) -> Refit:
    """The same model fitted with the sharpest friction (see `sharpen`)."""
    if not result.ids:
        return Refit(fit_with_sharp_friction(setting, result.fit), ())
    _, bounds = with_shapes(setting, result)
    return _with_its_shapes(result, fit_with_sharp_friction(setting, result.fit, bounds=bounds))


def _with_its_shapes(result: Refit, fit: Fit) -> Refit:
    """A refit's model with another fit of it, whose shape constants the effects get."""
    return Refit(fit, tuple(_at(v, fit.values) for v in result.variants))


def refit_longer_windows(setting: PreparedCampaign, result: Refit, factor: float = 3.0) -> Refit:
    """The same model fitted on windows `factor` times as long.

    What is still wrong with a model shows most over long times, and so does what its parameters
    should be to make the best of it. For a model that leaves noise alone it changes nothing.
    """
    longest = max(setting.recordings[i].duration for i in setting.fitted)
    step = min(float(np.median(np.diff(setting.prepared[i].t))) for i in setting.fitted)
    horizon = min(factor * result.fit.problem.windows.horizon, longest, MOST_SAMPLES * step)
    if horizon < 1.2 * result.fit.problem.windows.horizon:
        return result
    problem = setting.problem(horizon).at(result.fit.problem.tolerances)
    states = warm_start_states(result.fit, problem)
    _, bounds = with_shapes(setting, result)
    longer = fit(
        problem,
        result.fit.values,
        result.fit.unknowns,
        states,
        bounds=bounds,
        priors=result.fit.priors,
        max_iterations=25,
        relative=1e-6,
    )
    return _with_its_shapes(result, longer) if np.isfinite(longer.cost) else result


def removable(fit: Fit) -> float:
    """Sum of squares beyond what noise alone would leave."""
    r = fit.linearisation.r[:, :-4]
    return float((r**2).sum()) - fit.dof
