"""Nonlinear refits: the baseline with one or more effects added."""

import dataclasses
import logging
from collections.abc import Sequence

import numpy as np

from tp_jax.effects import Effect
from tp_jax.estimation.baseline import Setting, handed_on
from tp_jax.estimation.layout import Unknown, Values
from tp_jax.estimation.least_squares import Anchor, Fit, fit
from tp_jax.gap.directions import Variant

log = logging.getLogger(__name__)

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


def nuisances(effects: Sequence[Effect], setting: Setting) -> tuple[tuple[Unknown, ...], list[Anchor]]:
    """Zeros of phi2 become unknowns where an effect depends on phi2, one per recording."""
    if not any(e.uses_phi2 for e in effects):
        return (), []
    unknowns = tuple(Unknown("zero2", i) for i in setting.fitted)
    spec = setting.layout.parameters[setting.layout.index["zero2"]]
    return unknowns, [Anchor(u, 0.0, ZERO2_SD / spec.typical) for u in unknowns]


def refit(
    setting: Setting,
    before: Fit,
    variants: Sequence[Variant],
    start: dict[str, float] | None = None,
    *,
    horizon: float | None = None,
    max_iterations: int = 20,
) -> Refit:
    """Adds effects to a fit and finds the new optimum.

    Args:
        setting: the campaign.
        before: fit to start from (its unknowns are kept).
        variants: effects with shape constants, those of `before` included.
        start: amplitudes to start from, by slot; what `before` has if None.
        horizon: window length; that of `before` if None.
        max_iterations: see `least_squares.fit`.
    """
    unknowns = list(setting.unknowns())
    values = before.values
    extra, anchors = nuisances([v.effect for v in variants], setting)
    for v in variants:
        values = values.replace(v.settings)
        unknowns += [u for u in v.unknowns if u not in unknowns]
    unknowns += [u for u in extra if u not in unknowns]
    if start:
        values = _moved(values, start)
    problem, states = before.problem, before.states
    if horizon is not None and horizon != problem.windows.horizon:
        problem = setting.problem(horizon)
        states = handed_on(before, problem)
    base = [a for a in setting.anchors() if a.unknown in unknowns]
    result = fit(
        problem, values, unknowns, states, bounds=setting.bounds, anchors=[*base, *anchors],
        max_iterations=max_iterations, relative=1e-6,
    )  # fmt: skip
    log.info("%s: chi2/dof %.4g, %s", "+".join(v.effect.id for v in variants),
             result.chi2_dof, result.message)  # fmt: skip
    return Refit(result, tuple(variants))


def _moved(values: Values, start: dict[str, float]) -> Values:
    table = values.table.copy()
    for name, value in start.items():
        table[values.layout.index[name]] = value
    return Values(values.layout, table)


def polish_shapes(setting: Setting, result: Refit, max_iterations: int = 15) -> Refit:
    """Frees the continuous shape constants of the last effect, from where the grid left them."""
    last = result.variants[-1]
    free = [s for s in last.effect.shapes if s.continuous]
    if not free:
        return result
    names = [last.effect.qualified(s.name) for s in free]
    before = result.fit
    bounds = dict(setting.bounds)
    for s, name in zip(free, names, strict=True):
        bounds[name] = (min(s.grid) / 3.0, max(s.grid) * 3.0)
    unknowns = [*before.unknowns, *(Unknown(n) for n in names)]
    polished = fit(
        before.problem, before.values, unknowns, before.states, bounds=bounds,
        anchors=before.anchors, max_iterations=max_iterations, relative=1e-6,
    )  # fmt: skip
    if not polished.cost < before.cost:
        return result
    shapes = tuple(
        (s.name, polished.values.get(last.effect.qualified(s.name))) for s in last.effect.shapes
    )
    variant = dataclasses.replace(last, shapes=shapes)
    return Refit(polished, (*result.variants[:-1], variant))


def removable(fit: Fit) -> float:
    """Sum of squares beyond what noise alone would leave."""
    r = fit.linearisation.r[:, :-4]
    return float((r**2).sum()) - fit.dof


def amplitudes(result: Refit) -> dict[str, np.ndarray]:
    """Fitted amplitudes by slot (one number, or one per recording)."""
    out: dict[str, np.ndarray] = {}
    for v in result.variants:
        for u in v.unknowns:
            row = result.fit.values.layout.index[u.name]
            out[u.name] = result.fit.values.table[row]
    return out
