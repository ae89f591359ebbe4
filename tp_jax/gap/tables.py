"""The tables of a diagnosis: noise, causes, candidates, what is detectable, what was absorbed."""

from collections.abc import Collection, Mapping

import numpy as np

from tp_jax.effects import Law, catalogue
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.intervals import intervals
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.gap import detectability
from tp_jax.gap.agreement import agreement
from tp_jax.gap.applicability import why_not
from tp_jax.gap.calibration import Floor
from tp_jax.gap.choice import Choice
from tp_jax.gap.experiment import propose
from tp_jax.gap.held_out import HeldOut, Shrink, evaluate, shrink
from tp_jax.gap.law_curve import curve_of
from tp_jax.gap.policy import POLICY
from tp_jax.gap.refit import Refit, removable
from tp_jax.gap.screen import Scored
from tp_jax.recordings.noise import quantum
from tp_jax.results.diagnosis import Candidate, Cause, ChannelNoise, NextExperiment, Shift, Size


def noise(setting: PreparedCampaign) -> dict[str, ChannelNoise]:
    """The noise of each channel as estimated, of the recordings at the most usual rate."""
    out = {}
    for c, (name, sd) in enumerate(setting.noise.items()):
        colours = [setting.prepared[i].colour[c] for i in setting.fitted]
        colour = max(colours, key=colours.count)
        readings = [setting.recordings[i].channels[name] for i in setting.fitted]
        out[name] = ChannelNoise(
            sd=sd,
            white=colour.white,
            ar=tuple(colour.ar),
            lag_one=float(colour.correlation[0]) if colour.correlation else 0.0,
            quantum=float(np.median([quantum(y) for y in readings])),
            source="residuals" if colour.of_residuals else "data",
        )
    return out


def causes(
    setting: PreparedCampaign,
    choice: Choice,
    final: Refit,
    begun: HeldOut,
    held: Mapping[str, HeldOut],
    shrinks: Mapping[str, Shrink],
    total: Shrink,
    probabilities: Mapping[str, float],
    horizon: float,
    seed: int,
    least: Floor,
    unnamed: Collection[str],
) -> tuple[Cause, ...]:
    """The accepted causes, in order of contribution.

    Args:
        setting, choice, final: the campaign, the choice, and the model with the causes.
        begun: held-out windows where refits began. held: those of each effect added alone, with the
            same friction. shrinks: by effect, added alone.
        total: of all causes. probabilities: by effect. horizon: of windows [s]. seed: of `shrink`.
        least: noise floor. unnamed: effects that the model keeps, and that are no causes.
    """
    table = _sizes(setting, final)
    out: list[Cause] = []
    ids: list[str] = []
    for v in final.variants:
        ids.append(v.effect.id)
        if len(ids) == len(final.variants):
            value = total.value
        elif len(ids) == 1:
            value = shrinks[ids[0]].value if ids[0] in shrinks else None
        else:
            fit = next((r.refits[ids[-1]] for r in choice.rounds if r.taken == ids[-1]), None)
            value = None  # of one that took another's place nobody asked
            if fit is not None and fit.ids == tuple(ids):
                effects = [x.effect for x in fit.variants]
                measured = evaluate(setting, fit.fit.values, horizon, effects)
                value = shrink(setting, begun, measured, seed, least).value
        if v.effect.id in unnamed:
            continue
        more = {}
        if isinstance(v.effect, Law):
            more["curve"], more["formula"] = curve_of(setting, final.fit, v)
        if not out:
            more["agreement"] = agreement(
                v.effect.id, setting, choice, begun, held.get(v.effect.id)
            )
        out.append(
            Cause(
                effect=v.effect.id,
                kind="learned" if isinstance(v.effect, Law) else "catalogue",
                location=v.effect.location,
                channel=v.effect.channel,
                probability=probabilities.get(v.effect.id, 0.0),
                shrink=value,
                parameters=table[v.effect.id],
                remedy=v.effect.remedy,
                by_hand=v.effect.by_hand,
                **more,
            )
        )
    return tuple(out)


def _unit(effect, name: str) -> str:
    return next(s.unit for s in effect.shapes if s.name == name)


def _sizes(setting: PreparedCampaign, final: Refit) -> dict[str, dict[str, Size]]:
    """Amplitudes and shape constants of each cause; intervals of those that were fitted."""
    every = intervals(final.fit, setting)
    out = {}
    for v in final.variants:
        mine: dict[str, Size] = {}
        for a in v.effect.amplitudes:
            name = v.effect.qualified(a.name)
            if name in every:
                e = every[name]
                mine[a.name] = Size(e["value"], a.unit, tuple(e["ci95"]))
            else:
                own = [u.recording for u in v.unknowns if u.name == name]
                own = setting.fitted if v.effect.relative else own
                values = tuple(final.fit.values.get(name, i) for i in own)
                mine[a.name] = Size(values, a.unit, None)
        for name, x in v.shapes:
            e = every.get(v.effect.qualified(name))
            ends = None if e is None else tuple(e["ci95"])
            mine[name] = Size(float(x), _unit(v.effect, name), ends)
        out[v.effect.id] = mine
    return out


def candidates(
    setting, choice: Choice, probabilities, shrinks: dict[str, Shrink], against: dict[str, str]
) -> tuple[Candidate, ...]:
    """The whole catalogue, most probable first, and the laws that were refitted.

    `against` says by id what keeps an effect that fits better from being a cause.
    """
    first = choice.rounds[0]
    gap = max(removable(first.before), 1e-12)
    significant = first.structure.p < POLICY.structure.seen
    rows: list[Candidate] = []
    for s in first.screen.best():
        if isinstance(s.variant.effect, Law) and s.id not in first.refits:
            continue  # a curve that was only looked at is no entry of the catalogue
        realised = shrinks.get(s.id)
        rows.append(
            Candidate(
                effect=s.id,
                location=s.variant.effect.location,
                channel=s.variant.effect.channel,
                applicable=True,
                predicted_shrink=float(np.clip(s.drop / gap, 0.0, 1.0)) if significant else None,
                realised_shrink=realised.value if realised else None,
                probability=probabilities.get(s.id, 0.0),
                # of the wrong sign, a score is no evidence however large
                p=float(first.structure.by_variant[first.screen.scored.index(s)])
                if s.drop > 0.0
                else 1.0,
                note=None if s.id in choice.causes else against.get(s.id),
            )
        )
    rows.sort(key=lambda row: -(row.probability or 0.0))
    asked = {row.effect for row in rows}
    rows += [
        Candidate(
            effect=effect.id,
            location=effect.location,
            channel=effect.channel,
            applicable=False,
            predicted_shrink=None,
            realised_shrink=None,
            probability=None,
            note=why_not(effect, setting),
        )
        for effect in catalogue().values()
        if effect.id not in asked
    ]
    return tuple(rows)


def detectable(choice: Choice) -> dict[str, Size]:
    """From the last screen, whose residuals are nearest to the noise.

    Of a cause, at the shape constants of the grid that fit best. Of other effects nobody knows
    them, and those at which noise is fitted best may show a size that others hide: the middle size
    counts.
    """
    last, first = choice.rounds[-1], choice.rounds[0]
    formulas = [s for s in first.screen.best() if not isinstance(s.variant.effect, Law)]
    asked: dict[str, list[Scored]] = {s.id: [s] for s in formulas}
    for seen in (first, last):
        others = [s for s in seen.screen.scored if not isinstance(s.variant.effect, Law)]
        for id in {s.id for s in others} - set(choice.causes):
            asked[id] = [s for s in others if s.id == id]
    inflation = last.before.chi2_dof
    out = {}
    for id, several in sorted(asked.items()):
        value = detectability.middle_detectable(several, max(len(formulas), 1), inflation)
        out[id] = Size(value, several[0].variant.effect.amplitudes[0].unit)
    return out


def absorbed(setting: PreparedCampaign, baseline: Fit, after: Fit) -> dict[str, Shift]:
    errors = intervals(after, setting)
    out = {}
    for u in baseline.unknowns:
        if u.recording is not None or u.name not in errors:
            continue
        shift = baseline.values.get(u.name) - after.values.get(u.name)
        sd = errors[u.name]["standard_error"]
        out[u.name] = Shift(shift, shift / sd if sd else None, errors[u.name]["unit"])
    return out


def next_experiment(
    setting: PreparedCampaign, choice: Choice, no_gap: bool
) -> NextExperiment | None:
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
    return propose(setting, first.before, scored[lead], rivals[0]) if rivals else None


def _by_recording(scored: Scored) -> bool:
    """True where its amplitudes belong to recordings, so that one more run says nothing of them."""
    return any(u.recording is not None for u in scored.variant.unknowns)
