"""A diagnosis from a choice of causes: what the held-out recordings say, and every table of it."""

import dataclasses
from collections.abc import Sequence

import numpy as np

from tp_jax import _tails as tails
from tp_jax.estimation.assemble import fit_record
from tp_jax.estimation.intervals import correlations, intervals
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.gap import tables
from tp_jax.gap.acceptance import (
    errors,
    free_errors,
    is_worse,
    least_probable,
    tied,
    without_doubt,
    without_harm,
)
from tp_jax.gap.by_recording import shrink_by_recording
from tp_jax.gap.calibration import Floor, floor
from tp_jax.gap.choice import Choice
from tp_jax.gap.free_structure import free_structure
from tp_jax.gap.held_out import (
    HeldOut,
    Shrink,
    common_horizon,
    evaluate,
    expected_elsewhere,
    floor_error,
    shrink,
)
from tp_jax.gap.location import locate
from tp_jax.gap.misfit import excess
from tp_jax.gap.notes import beyond_its_range, elsewhere, notes, why_no_cause
from tp_jax.gap.policy import POLICY
from tp_jax.gap.refit import Refit
from tp_jax.gap.relative import centred, told
from tp_jax.gap.screen import screen
from tp_jax.gap.series import curves, recordings, residuals
from tp_jax.gap.structure import structure_test
from tp_jax.gap.unpredicted import unpredicted
from tp_jax.gap.verdict import Evidence, combined, verdict
from tp_jax.results.diagnosis import (
    VERSION,
    Correlation,
    DiagnosisRecord,
    Fits,
    FloorParts,
    Gap,
    LackOfFits,
    Misfits,
    Size,
)


def assemble(
    setting: PreparedCampaign,
    choice: Choice,
    seed: int,
    tolerance: float = 0.0,
    more: Sequence[str] = (),
) -> DiagnosisRecord:
    """The result as `diagnosis.json` has it, without its provenance; `more`: notes at its end."""
    horizon = common_horizon(setting, choice.baseline.problem.windows.horizon)
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
    alone = {**held}  # with the friction that refits have
    after = before
    if final.ids:
        after = evaluate(setting, final.fit.values, horizon, [v.effect for v in final.variants])
        if len(final.ids) == 1:
            held[final.ids[0]] = after
    total = shrink(setting, before, after, seed, least)
    first = choice.rounds[0]
    beyond = excess(setting, baseline, least)
    before_rest = free_structure(setting, baseline)
    after_rest = free_structure(setting, final.fit) if final.ids else before_rest
    structure_p = combined(first.structure.p, before_rest.p, beyond)
    structure_p = min(choice.looks * structure_p, 1.0)
    # what the fitted recordings do not show the held-out ones may
    apart = unpredicted(setting, baseline, before) if before.complete else 0.0
    seen_apart = structure_p >= POLICY.structure.alarm and apart > POLICY.structure.unpredicted
    there_alone = seen_apart and not final.ids
    if seen_apart:
        structure_p = float(tails.normal(apart))
    structure_p_after = structure_p
    if final.ids:
        left = excess(setting, final.fit, least)
        rest = choice.structure
        if dropped or doubts.gone:  # the last round looked beside causes that are gone
            seen = screen(final.fit, setting, skip=final.ids, states=False)
            rest = structure_test(seen, seed)
            last = dataclasses.replace(choice.rounds[-1], structure=rest)
            choice = dataclasses.replace(choice, rounds=(*choice.rounds[:-1], last))
        structure_p_after = combined(rest.p, after_rest.p, left)
    start_before, free_before = free_errors(before.setting or setting, before.fit.values, horizon)
    start_after, free_after = (
        free_errors(after.setting or setting, after.fit.values, horizon)
        if final.ids
        else (start_before, free_before)
    )
    gap_before, gap_after = errors(before, free_before), errors(after, free_after)
    worse = final.ids if final.ids and is_worse(gap_before, gap_after) else ()
    word = verdict(
        _evidence(
            setting,
            choice,
            before,
            after,
            least,
            structure_p,
            structure_p_after,
            least_probable(setting, choice, probabilities),
            total,
            bool(worse),
            gap_before.free_run,
            gap_after.free_run,
        ),
        tolerance,
    )
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
        setting,
        choice,
        final,
        word,
        structure_p_after,
        after_rest,
        least,
        before.complete and after.complete,
        worse or dropped,
        doubts,
        there_alone,
    )
    # of what no fitted recording shows no place was asked
    where = () if no_gap or there_alone else locate(choice, setting, seed)
    said += elsewhere(where, final)
    said += beyond_its_range(setting, final, after.fit)
    labels = [r.label for r in setting.recordings]
    against = why_no_cause(choice, worse or dropped, doubts)
    fit_before = fit_record(before.fit.values, (), labels)
    told_after = centred(after.fit.values, [v.effect for v in final.variants], setting.fitted)
    expected = expected_elsewhere(told_after, setting, setting.fitted, [0])
    fit_after = fit_record(told_after, ids, labels, expected) if ids else None
    return DiagnosisRecord(
        schema=VERSION,
        campaign=setting.campaign.name,
        model=setting.model,
        verdict=word,
        noise_floor={**least.total},
        noise=tables.noise(setting),
        noise_floor_parts=FloorParts({**least.noise}, {**least.calibration}),
        gap=Gap(
            before=gap_before,
            after=gap_after if ids else gap_before,
            shrink=total.value if ids else (None if not total.significant else 0.0),
            shrink_ci95=total.ci95 if ids else None,
            shrink_by_recording=(
                {**shrink_by_recording(setting, choice, horizon, seed)} if ids else {}
            ),
            held_out=tuple(setting.recordings[i].name for i in setting.held_out),
            horizon_s=horizon,
            removable_significant=total.significant,
            structure_p=structure_p,
            structure_p_after=structure_p_after if ids else None,
            free_structure=(
                LackOfFits(before_rest, after_rest) if ids else LackOfFits(before_rest)
            ),
            excess_z=beyond,
            unpredicted=there_alone and not no_gap,
            tolerance=tolerance,
            rejected=(*worse, *dropped, *doubts.gone),
            chi2_dof=Misfits(baseline.chi2_dof, final.fit.chi2_dof),
        ),
        where=tuple(where),
        accepted=tables.causes(
            setting,
            choice,
            final,
            begun,
            alone,
            shrinks,
            total,
            probabilities,
            horizon,
            seed,
            least,
            doubts.unnamed,
        ),
        candidates=tables.candidates(setting, choice, probabilities, shrinks, against),
        confused_with=tuple(map(tuple, tied(setting, choice, no_gap))),
        minimum_detectable=tables.detectable(choice),
        absorbed=tables.absorbed(setting, baseline, final.fit) if ids else {},
        fits=Fits.read({"before": fit_before, "after": fit_after}),
        parameters={n: Size.read(e) for n, e in intervals(final.fit, setting).items()},
        correlation=Correlation.read(correlations(final.fit, setting)),
        next_experiment=tables.next_experiment(setting, choice, no_gap),
        recordings=recordings(setting, start_before, start_after if ids else {}),
        curves=curves(setting, free_before, free_after if ids else None),
        residuals=residuals(setting, before, after if ids else None, least),
        notes=(*said, *more),
    )


def _evidence(
    setting: PreparedCampaign,
    choice: Choice,
    before: HeldOut,
    after: HeldOut,
    least: Floor,
    structure_p: float,
    structure_p_after: float,
    probability: float,
    total: Shrink,
    worse: bool,
    free_before: float | None,
    free_after: float | None,
) -> Evidence:
    floor2 = float(np.mean([v**2 for v in least.total.values()]))
    left, gap = after.mean_square() - floor2, before.mean_square() - floor2
    levels = np.array([*least.noise.values(), 0.0])[:2]
    error = float(np.hypot(floor_error(setting), after.chance(levels)))
    error = float(np.hypot(error, np.sqrt(2.0) * least.parts.sum() / max(floor2, 1e-300)))

    def beyond(windowed: float, free: float | None) -> float:
        """Returns the excess over noise, windowed or in a free run [rad]; infinite if one fails."""
        run = np.inf if free is None else free**2 - floor2
        return float(np.sqrt(max(windowed, run, 0.0)))

    return Evidence(
        structure_p,
        structure_p_after,
        len(choice.causes),
        probability,
        total,
        left / max(floor2, 1e-300),
        error,
        beyond(gap, free_before),
        beyond(left, free_after),
        worse,
    )
