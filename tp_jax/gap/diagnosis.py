"""`diagnose`: from a campaign to where the gap lies, what causes it and how far it shrinks."""

import dataclasses
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from tp_jax._version import __version__
from tp_jax.effects import catalogue
from tp_jax.errors import InputError
from tp_jax.estimation.assemble import fit_record
from tp_jax.estimation.baseline import Setting, grow, initial_values, prepare_campaign
from tp_jax.estimation.intervals import intervals
from tp_jax.estimation.least_squares import Fit
from tp_jax.estimation.residual_noise import with_residual_noise
from tp_jax.estimation.variable_projection import fit
from tp_jax.gap import detectability
from tp_jax.gap.acceptance import (
    errors,
    free_errors,
    is_worse,
    least_probable,
    tied,
    without_doubt,
    without_harm,
)
from tp_jax.gap.applicability import check_predictable, why_not
from tp_jax.gap.calibration import Floor, floor
from tp_jax.gap.choice import Choice, choose
from tp_jax.gap.experiment import propose
from tp_jax.gap.free_structure import free_structure
from tp_jax.gap.held_out import HeldOut, Shrink, carried_over, evaluate, floor_error, shrink
from tp_jax.gap.location import locate
from tp_jax.gap.notes import elsewhere, notes
from tp_jax.gap.policy import POLICY, NoisePolicy
from tp_jax.gap.refit import Refit, lengthened, removable
from tp_jax.gap.relative import told
from tp_jax.gap.screen import Scored, screen
from tp_jax.gap.series import curves, recordings, residuals
from tp_jax.gap.structure import structure_test
from tp_jax.gap.verdict import Evidence, combined, verdict
from tp_jax.recordings import Campaign, hold_out
from tp_jax.recordings.noise import quantum

SCHEMA = "tp-jax/diagnosis/1"


@dataclasses.dataclass(frozen=True)
class Diagnosis:
    """What `diagnose` found; `to_dict` is diagnosis.json."""

    result: dict[str, Any]

    @property
    def verdict(self) -> str:
        """explained, no_gap or unknown."""
        return self.result["verdict"]

    @property
    def causes(self) -> list[str]:
        """Ids of the accepted causes, in order of contribution."""
        return [c["effect"] for c in self.result["causes"]]

    def to_dict(self) -> dict[str, Any]:
        """The result as plain numbers, lists and strings."""
        return self.result


def _silent(stage: str, fraction: float | None) -> None:
    """Reports to nobody."""


def diagnose(
    campaign: Campaign,
    *,
    model: str = "newton",
    seed: int = 0,
    tolerance: float = 0.0,
    progress: Callable[[str, float | None], None] | None = None,
) -> Diagnosis:
    """Where the model falls short of a campaign, which effect is missing, and what it gains.

    Args:
        campaign: see `load_campaign`. Where no recording is marked held out, one is.
        model: "newton" or "paper".
        seed: of every random draw.
        tolerance: root mean square [rad] below which a gap matters to nobody.
        progress: called with a stage's name and the part of it that is done.

    Returns:
        A `Diagnosis`. The choice of causes uses the fitted recordings alone; the held-out ones
        are read once, after it.
    """
    begin = time.perf_counter()
    progress = progress or _silent
    campaign = hold_out(campaign)
    setting = prepare_campaign(campaign, model=model)
    check_predictable(setting)
    setting.problem(setting.horizons[0]).compile_ahead(frozenset())
    baseline = grow(setting, initial_values(setting), setting.unknowns(), progress=progress)
    if not np.isfinite(baseline.cost):
        raise InputError(
            "The model cannot be integrated through the recordings from any start; check the units "
            "of times and angles, and that omega is in rad/s."
        )
    setting, choice = _chosen(setting, baseline, seed, progress)
    progress("reading the held-out recordings", None)
    result = _report(setting, choice, seed, tolerance)
    result["provenance"] = {
        "version": __version__,
        "seed": seed,
        "data_sha256": campaign.data_sha256,
        "wall_s": round(time.perf_counter() - begin, 2),
    }
    return Diagnosis(result)


def _chosen(
    setting: Setting, baseline: Fit, seed: int, progress: Callable[[str, float | None], None]
) -> tuple[Setting, Choice]:
    """The causes, and the campaign with its noise as it shows once they are in.

    Where the data alone do not say what colour the noise has, what the baseline leaves does, and
    some of that may be gap. What the causes leave says it better; then all is judged anew.
    """
    asked = baseline.chi2_dof < POLICY.noise.below
    if asked:
        setting, baseline = with_noise_of(setting, baseline, baseline)
    choice = choose(setting, baseline, seed, progress)
    if all(not r.forced for r in setting.recordings):
        setting, baseline, choice = _looked_longer(setting, baseline, choice, seed, progress)
    if choice.final.ids or not asked:
        if not alike(setting, with_residual_noise(setting, choice.final.fit)):
            better, again = with_noise_of(setting, choice.final.fit, baseline)
            looks = choice.looks
            choice = choose(better, again, seed, progress, choice.final)
            return better, dataclasses.replace(choice, looks=looks)
    return setting, choice


def alike(one: Setting, other: Setting, policy: NoisePolicy = POLICY.noise) -> bool:
    """Whether a campaign has about the same noise in both."""
    ratio = np.abs(np.log(one.levels / other.levels))[one.fitted]
    if ratio.max() > policy.level:
        return False
    pairs = [
        pair
        for i in one.fitted
        for pair in zip(one.prepared[i].colour, other.prepared[i].colour, strict=True)
    ]
    return all(
        abs(a.neighbours - b.neighbours) <= policy.correlation
        and max(a.slow, b.slow) <= policy.slow * min(a.slow, b.slow)
        for a, b in pairs
    )


def _looked_longer(
    setting: Setting, baseline: Fit, choice: Choice, seed: int,
    progress: Callable[[str, float | None], None],
) -> tuple[Setting, Fit, Choice]:  # fmt: skip
    """Decays over longer windows, where shorter ones show no cause.

    A drag that takes a hundredth of the energy in a period is hidden by the noise of a window of
    one and a half, and plain after ten. The parameters are the better known for it, too.
    """
    policy = POLICY.horizon
    for look in range(policy.looks):
        if choice.final.ids or baseline.chi2_dof >= policy.below:
            break
        longer = lengthened(setting, Refit(baseline, ()), policy.factor).fit
        if longer is baseline:
            break
        progress("longer windows", None)
        setting, baseline = with_noise_of(setting, longer, longer)
        choice = choose(setting, baseline, seed, progress)
        choice = dataclasses.replace(choice, looks=look + 2)
    return setting, baseline, choice


def with_noise_of(setting: Setting, shown: Fit, baseline: Fit) -> tuple[Setting, Fit]:
    """The campaign with the noise that a fit shows, and the baseline under it.

    A fit under white noise absorbs some of a colour where its windows start at rest, so that of the
    baseline is looked at once more under what it showed first.
    """
    own = shown is baseline
    for _ in range(2 if own else 1):
        found = with_residual_noise(setting, shown)
        if found is setting:
            break
        setting, problem = found, found.problem(baseline.problem.windows.horizon)
        baseline = fit(
            problem, baseline.values, baseline.unknowns, baseline.states, bounds=found.bounds,
            anchors=baseline.anchors, relative=1e-7,
        )  # fmt: skip
        shown = baseline
    return setting, baseline


def _report(setting: Setting, choice: Choice, seed: int, tolerance: float = 0.0) -> dict[str, Any]:
    horizon = _common_horizon(setting, choice.baseline.problem.windows.horizon)
    choice, dropped = without_harm(setting, choice, horizon)
    choice, probabilities, doubts = without_doubt(setting, choice, horizon)
    baseline, final = choice.baseline, choice.final
    before = evaluate(setting, baseline.values, horizon)
    least = floor(setting, baseline, before.fit)
    singles = {id: r for id, r in choice.rounds[0].refits.items()}
    held: dict[str, HeldOut] = {
        id: evaluate(setting, r.fit.values, horizon, [v.effect for v in r.variants])
        for id, r in singles.items()
    }
    after = before
    if final.ids:
        after = evaluate(setting, final.fit.values, horizon, [v.effect for v in final.variants])
        if len(final.ids) == 1:
            held[final.ids[0]] = after
    total = shrink(setting, before, after, seed, least)
    first = choice.rounds[0]
    excess = _excess(setting, baseline, least)
    anything = {"before": free_structure(setting, baseline)}
    anything["after"] = free_structure(setting, final.fit) if final.ids else anything["before"]
    structure_p = combined(first.structure.p, anything["before"].p, excess)
    structure_p = min(choice.looks * structure_p, 1.0)
    structure_p_after = structure_p
    if final.ids:
        left = _excess(setting, final.fit, least)
        rest = choice.structure
        if dropped or doubts.gone:  # the last round looked beside causes that are gone
            seen = screen(final.fit, setting, skip=final.ids, states=False)
            rest = structure_test(seen, seed)
        structure_p_after = combined(rest.p, anything["after"].p, left)
    start_before, free_before = free_errors(setting, baseline, horizon)
    start_after, free_after = (
        free_errors(setting, final.fit, horizon) if final.ids else (start_before, free_before)
    )
    gap_before, gap_after = errors(before, free_before), errors(after, free_after)
    worse = final.ids if final.ids and is_worse(gap_before, gap_after) else ()
    word = verdict(
        _evidence(
            setting, choice, before, after, least, structure_p, structure_p_after,
            least_probable(setting, choice, probabilities), total, bool(worse),
            gap_before["free_run"], gap_after["free_run"],
        ), tolerance,
    )  # fmt: skip
    no_gap = word == "no_gap"
    # refits are compared with where they began, which has the smoothing that they have
    begun = evaluate(setting, first.searched.values, horizon)
    shrinks = {
        id: shrink(setting, before if h is after else begun, h, seed, least)
        for id, h in held.items()
    }
    final = Refit(baseline, ()) if no_gap or worse else told(final, setting.fitted)
    ids = final.ids
    if worse:  # where the gap lies is then asked without a cause
        rounds = tuple(dataclasses.replace(r, taken=None) for r in choice.rounds)
        choice = dataclasses.replace(choice, rounds=rounds, final=final)
    said = notes(
        setting, choice, final, word, structure_p_after, anything["after"], least,
        before.complete and after.complete, worse or dropped, doubts,
    )  # fmt: skip
    where = [] if no_gap else locate(choice, setting, seed)
    said += elsewhere(where, final)
    labels = [r.label for r in setting.recordings]
    return {
        "schema": SCHEMA,
        "campaign": setting.campaign.name,
        "model": setting.model,
        "verdict": word,
        "noise_floor": least.total,
        "noise": _noise(setting),
        "noise_floor_parts": {"noise": least.noise, "calibration": least.calibration},
        "gap": {
            "before": gap_before,
            "after": gap_after if ids else gap_before,
            "shrink": total.value if ids else (None if not total.significant else 0.0),
            "shrink_ci95": list(total.ci95) if ids and total.ci95 else None,
            "held_out": [setting.recordings[i].name for i in setting.held_out],
            "horizon_s": horizon,
            "removable_significant": total.significant,
            "structure_p": structure_p,
            "structure_p_after": structure_p_after if ids else None,
            "free_structure": {
                when: dataclasses.asdict(found)
                for when, found in anything.items()
                if ids or when == "before"
            },
            "excess_z": excess,
            "tolerance": tolerance,
            "rejected": [*worse, *dropped, *doubts.gone],
            "chi2_dof": {"before": baseline.chi2_dof, "after": final.fit.chi2_dof},
        },
        "where": [dataclasses.asdict(s) for s in where],
        "causes": _causes(
            setting,
            choice,
            final,
            begun,
            shrinks,
            total,
            probabilities,
            horizon,
            seed,
            least,
            doubts.unnamed,
        ),
        "candidates": _candidates(setting, choice, probabilities, shrinks),
        "confused_with": tied(setting, choice, no_gap),
        "minimum_detectable": _detectable(choice),
        "absorbed": _absorbed(setting, baseline, final.fit) if ids else {},
        "fits": {
            "before": fit_record(carried_over(baseline.values, setting), (), labels),
            "after": fit_record(carried_over(final.fit.values, setting), ids, labels)
            if ids
            else None,
        },
        "parameters": intervals(final.fit, setting),
        "next_experiment": _next(setting, choice, no_gap),
        "recordings": recordings(setting, start_before, start_after, bool(ids)),
        "curves": curves(setting, free_before, free_after if ids else None),
        "residuals": residuals(setting, before, after if ids else None, least),
        "notes": said,
    }


def _noise(setting: Setting) -> dict[str, dict[str, Any]]:
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


def _evidence(
    setting: Setting, choice: Choice, before: HeldOut, after: HeldOut, least: Floor,
    structure_p: float, structure_p_after: float, probability: float, total: Shrink, worse: bool,
    free_before: float | None, free_after: float | None,
) -> Evidence:  # fmt: skip
    floor2 = float(np.mean([v**2 for v in least.total.values()]))
    left, gap = after.mean_square() - floor2, before.mean_square() - floor2
    levels = np.array([*least.noise.values(), 0.0])[:2]
    error = float(np.hypot(floor_error(setting), after.chance(levels)))
    error = float(np.hypot(error, np.sqrt(2.0) * least.parts.sum() / max(floor2, 1e-300)))

    def beyond(windowed: float, free: float | None) -> float:
        """What exceeds the noise in windows or in a free run [rad]; infinite of one that fails."""
        run = np.inf if free is None else free**2 - floor2
        return float(np.sqrt(max(windowed, run, 0.0)))

    return Evidence(
        structure_p, structure_p_after, len(choice.causes), probability, total,
        left / max(floor2, 1e-300), error, beyond(gap, free_before), beyond(left, free_after),
        worse,
    )  # fmt: skip


def _common_horizon(setting: Setting, horizon: float) -> float:
    longest = max(setting.recordings[i].duration for i in setting.held_out)
    return float(min(horizon, longest))


def _excess(setting: Setting, baseline: Fit, least: Floor) -> float:
    """Standard errors by which the misfit exceeds the floor, its own uncertainty included."""
    error = np.hypot(floor_error(setting), np.sqrt(2.0 / max(baseline.dof, 1)))
    error = np.hypot(error, np.sqrt(2.0 * np.sum(least.misfit**2)))
    # Correlated residuals have fewer degrees of freedom; the floor's error dominates anyway.
    return float((baseline.chi2_dof - 1.0 - least.misfit.sum()) / error)


def _causes(
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
                "location": v.effect.location,
                "channel": v.effect.channel,
                "probability": probabilities.get(v.effect.id, 0.0),
                "shrink": value,
                "parameters": table[v.effect.id],
            }
        )  # fmt: skip
    return out


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


def _candidates(setting, choice: Choice, probabilities, shrinks: dict[str, Shrink]) -> list[dict]:
    first = choice.rounds[0]
    gap = max(removable(first.before), 1e-12)
    significant = first.structure.p < POLICY.structure.seen
    rows = []
    for s in first.screen.best():
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


def _detectable(choice: Choice) -> dict[str, dict | None]:
    """From the last screen, whose residuals are nearest to the noise."""
    last, first = choice.rounds[-1], choice.rounds[0]
    out: dict[str, dict | None] = {}
    tests = max(len(first.screen.best()), 1)
    for s in [*last.screen.best(), *first.screen.best()]:
        if s.id in out:
            continue
        inflation = last.before.chi2_dof
        value = detectability.minimum_detectable(s, tests, inflation)
        out[s.id] = {"value": value, "unit": s.variant.effect.amplitudes[0].unit}
    return dict(sorted(out.items()))


def _absorbed(setting: Setting, baseline: Fit, after: Fit) -> dict[str, dict]:
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


def _next(setting: Setting, choice: Choice, no_gap: bool) -> dict | None:
    """A run that separates the best effect from its nearest rival."""
    if no_gap:
        return None
    first = choice.rounds[0]
    best = [s for s in first.screen.best() if not _by_recording(s)]
    scored = {s.id: s for s in best}
    lead = choice.causes[0] if choice.causes else (best[0].id if best else None)
    if lead not in scored:
        return None
    rivals = sorted(
        (s for s in best if s.id != lead),
        key=lambda s: -detectability.cosine(first.screen, scored[lead], s),
    )
    for rival in rivals[:1]:
        found = propose(setting, first.before, scored[lead], rival)
        if found is not None:
            return {**dataclasses.asdict(found), "separates": list(found.separates)}
    return None


def _by_recording(scored: Scored) -> bool:
    """Whether its amplitudes belong to recordings, so that one more run says nothing of them."""
    return any(u.recording is not None for u in scored.variant.unknowns)
