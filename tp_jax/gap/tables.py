"""The tables of a diagnosis: noise, causes, candidates, what is detectable, what was absorbed."""

import dataclasses
from typing import Any

import numpy as np

from tp_jax.effects import Law, catalogue
from tp_jax.estimation.baseline import Setting
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.intervals import intervals
from tp_jax.gap import detectability
from tp_jax.gap.applicability import why_not
from tp_jax.gap.choice import Choice
from tp_jax.gap.directions import Variant
from tp_jax.gap.experiment import propose
from tp_jax.gap.held_out import Shrink, evaluate, shrink
from tp_jax.gap.law_curve import curve_of
from tp_jax.gap.policy import POLICY
from tp_jax.gap.refit import Refit, removable
from tp_jax.gap.screen import Scored
from tp_jax.recordings.noise import quantum


def noise(setting: Setting) -> dict[str, dict[str, Any]]:
    """The noise of each channel as estimated, of the recordings at the most usual rate."""
    out = {}
    for c, (name, sd) in enumerate(setting.noise.items()):
        colours = [setting.prepared[i].colour[c] for i in setting.fitted]
        colour = max(colours, key=colours.count)
        readings = [setting.recordings[i].channels[name] for i in setting.fitted]
        out[name] = {
            "sd": sd,
            "white": colour.white,
            "ar": list(colour.ar),
            "lag_one": float(colour.correlation[0]) if colour.correlation else 0.0,
            "quantum": float(np.median([quantum(y) for y in readings])),
            "from": "residuals" if colour.of_residuals else "data",
        }
    return out


def causes(
    setting, choice, final, begun, shrinks, total, probabilities, horizon, seed, least, unnamed
) -> list[dict]:
    table = _sizes(setting, final)
    out = []
    ids: list[str] = []
    for v in final.variants:
        ids.append(v.effect.id)
        if len(ids) == len(final.variants):
            value = total.value
        elif len(ids) == 1:
            value = shrinks[ids[0]].value if ids[0] in shrinks else None
        else:
            fit = next((r.refits[r.taken] for r in choice.rounds if r.taken == ids[-1]), None)
            value = None  # of one that took another's place nobody asked
            if fit is not None and fit.ids == tuple(ids):
                effects = [x.effect for x in fit.variants]
                measured = evaluate(setting, fit.fit.values, horizon, effects)
                value = shrink(setting, begun, measured, seed, least).value
        if v.effect.id in unnamed:
            continue
        out.append(
            {
                "effect": v.effect.id,
                "kind": "learned" if isinstance(v.effect, Law) else "catalogue",
                "location": v.effect.location,
                "channel": v.effect.channel,
                "probability": probabilities.get(v.effect.id, 0.0),
                "shrink": value,
                "parameters": table[v.effect.id],
                "remedy": v.effect.remedy,
                "by_hand": v.effect.by_hand,
            }
            | (_curve(setting, final, v) if isinstance(v.effect, Law) else {})
        )  # fmt: skip
    return out


def _curve(setting: Setting, final: Refit, v: Variant) -> dict[str, Any]:
    """Returns what a learned cause has in addition: its curve, and a short formula for it."""
    found = curve_of(setting, final.fit, v)
    return {"formula": found.pop("formula"), "curve": found}


def _unit(effect, name: str) -> str:
    return next(s.unit for s in effect.shapes if s.name == name)


def _sizes(setting: Setting, final: Refit) -> dict[str, dict]:
    """Amplitudes and shape constants of each cause; intervals of those that were fitted."""
    every = intervals(final.fit, setting)
    out: dict[str, dict] = {}
    for v in final.variants:
        mine = {}
        for a in v.effect.amplitudes:
            name = v.effect.qualified(a.name)
            if name in every:
                e = every[name]
                mine[a.name] = {"value": e["value"], "unit": a.unit, "ci95": e["ci95"]}
            else:
                own = [u.recording for u in v.unknowns if u.name == name]
                own = setting.fitted if v.effect.relative else own
                values = [final.fit.values.get(name, i) for i in own]
                mine[a.name] = {"value": values, "unit": a.unit, "ci95": None}
        for name, x in v.shapes:
            e = every.get(v.effect.qualified(name), {})
            mine[name] = {"value": float(x), "unit": _unit(v.effect, name), "ci95": e.get("ci95")}
        out[v.effect.id] = mine
    return out


def candidates(
    setting, choice: Choice, probabilities, shrinks: dict[str, Shrink], against: dict[str, str]
) -> list[dict]:
    """The whole catalogue, most probable first, and the laws that were refitted.

    `against` says by id what keeps an effect that fits better from being a cause.
    """
    first = choice.rounds[0]
    gap = max(removable(first.before), 1e-12)
    significant = first.structure.p < POLICY.structure.seen
    rows = []
    for s in first.screen.best():
        if isinstance(s.variant.effect, Law) and s.id not in first.refits:
            continue  # a curve that was only looked at is no entry of the catalogue
        realised = shrinks.get(s.id)
        rows.append(
            {
                "effect": s.id,
                "location": s.variant.effect.location,
                "channel": s.variant.effect.channel,
                "applicable": True,
                "predicted_shrink": float(np.clip(s.drop / gap, 0.0, 1.0)) if significant else None,
                "realised_shrink": realised.value if realised else None,
                "probability": probabilities.get(s.id, 0.0),
                # of the wrong sign, a score is no evidence however large
                "p": float(first.structure.by_variant[first.screen.scored.index(s)])
                if s.drop > 0.0
                else 1.0,
                "note": None if s.id in choice.causes else against.get(s.id),
            }
        )
    rows.sort(key=lambda row: -row["probability"])
    for effect in catalogue().values():
        if effect.id in {row["effect"] for row in rows}:
            continue
        note = why_not(effect, setting)
        rows.append(
            {
                "effect": effect.id, "location": effect.location, "channel": effect.channel,
                "applicable": False, "predicted_shrink": None, "realised_shrink": None,
                "probability": None, "note": note,
            }
        )  # fmt: skip
    return rows


def detectable(choice: Choice) -> dict[str, dict | None]:
    """Computes detectable sizes from the last screen, whose residuals are nearest to the noise."""
    last, first = choice.rounds[-1], choice.rounds[0]
    out: dict[str, dict | None] = {}
    formulas = [s for s in first.screen.best() if not isinstance(s.variant.effect, Law)]
    tests = max(len(formulas), 1)
    for s in [*last.screen.best(), *first.screen.best()]:
        if s.id in out or isinstance(s.variant.effect, Law):
            continue
        inflation = last.before.chi2_dof
        value = detectability.minimum_detectable(s, tests, inflation)
        out[s.id] = {"value": value, "unit": s.variant.effect.amplitudes[0].unit}
    return dict(sorted(out.items()))


def absorbed(setting: Setting, baseline: Fit, after: Fit) -> dict[str, dict]:
    errors = intervals(after, setting)
    out = {}
    for u in baseline.unknowns:
        if u.recording is not None or u.name not in errors:
            continue
        shift = baseline.values.get(u.name) - after.values.get(u.name)
        sd = errors[u.name]["standard_error"]
        out[u.name] = {
            "shift": shift,
            "in_standard_errors": shift / sd if sd else None,
            "unit": errors[u.name]["unit"],
        }
    return out


def next_experiment(setting: Setting, choice: Choice, no_gap: bool) -> dict | None:
    """A run that separates the best effect from its nearest rival."""
    if no_gap:
        return None
    first = choice.rounds[0]
    best = [s for s in first.screen.best() if not _by_recording(s)]
    scored = {s.id: s for s in best}
    lead = choice.causes[0] if choice.causes else (best[0].id if best else None)
    if lead not in scored:
        return None
    # laws have slots in common, so that a run is not asked to tell one from another
    slots = scored[lead].variant.effect.slots
    rivals = sorted(
        (s for s in best if s.id != lead and not (slots and slots == s.variant.effect.slots)),
        key=lambda s: -detectability.cosine(first.screen, scored[lead], s),
    )
    for rival in rivals[:1]:
        found = propose(setting, first.before, scored[lead], rival)
        if found is not None:
            return {**dataclasses.asdict(found), "separates": list(found.separates)}
    return None


def _by_recording(scored: Scored) -> bool:
    """True where its amplitudes belong to recordings, so that one more run says nothing of them."""
    return any(u.recording is not None for u in scored.variant.unknowns)
