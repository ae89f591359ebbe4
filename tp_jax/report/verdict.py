"""The verdict in three plain sentences: where the gap lies, what causes it, how far it shrinks."""

import re
from collections.abc import Sequence
from typing import NamedTuple

from tp_jax.report import words
from tp_jax.report.formatting import (
    angle,
    angles,
    number,
    p_value,
    percent,
    percents,
    probability,
    size,
    unit,
)
from tp_jax.results.diagnosis import Cause, DiagnosisRecord, Found

_HEADINGS = {
    "explained": "The gap is explained",
    "no_gap": "No gap was found",
    "unknown": "There is a gap that is not explained",
}

_STARTS = (
    "when",
    "where",
    "while",
    "at ",
    "in ",
    "above",
    "below",
    "around",
    "near",
    "after",
    "before",
    "during",
    "throughout",
    "mainly",
    "mostly",
)

_LEVEL = 0.05  # of the test of structure, of what causes leave
_ALARM = 0.025  # of the same, before
_CERTAIN = 0.9  # probability from which a cause is


class Verdict(NamedTuple):
    """Sentences that a reader takes away.

    Attributes:
        heading: the verdict in a few words.
        where, what, how_far: one sentence each.
        tied: what the causes cannot be told from; empty where there is nothing.
        agreement: in how many recordings the first cause improves the fit; empty where that is not
            known.
        remedy: what to do about the causes at the rig, and how to check each by hand; empty where
            nobody has said.
        error: how close the model comes to held-out data; empty where it is not known.
        left: whether what stays still has structure; empty where that is not known or not so.
    """

    heading: str
    where: str
    what: str
    how_far: str
    tied: str = ""
    error: str = ""
    left: str = ""
    agreement: str = ""
    remedy: str = ""


def sentences(found: Found) -> Verdict:
    """The verdict of a diagnosis in words."""
    diagnosis = DiagnosisRecord.read(found)
    kind, causes = diagnosis.verdict, diagnosis.accepted
    if kind is None:
        return Verdict(
            "There is no verdict",
            "The diagnosis does not say whether there is a gap.",
            _what(diagnosis) if causes else "No cause is given.",
            _how_far(diagnosis),
            error=_error(diagnosis),
        )
    if kind == "no_gap":
        heading = _HEADINGS[kind]
        if _has_structure(diagnosis.gap.structure_p, _ALARM):
            heading = "The gap is below the tolerance"
        said = heading, _no_gap(diagnosis), "No effect needs to be added to the model."
        return Verdict(*said, _unseen(diagnosis), error=_error(diagnosis))
    heading = _HEADINGS[kind]
    if kind == "unknown" and causes:
        heading = "The gap is explained only in part"
        if _nothing_left(diagnosis):
            one = len(causes) == 1
            heading = f"{'A cause was' if one else 'Causes were'} found, but not for certain"
            if all((cause.probability or 0.0) >= _CERTAIN for cause in causes):
                heading = (
                    "A cause was found, but it does not explain all of what was not fitted"
                    if one
                    else "Causes were found, but they do not explain all of what was not fitted"
                )
    return Verdict(
        heading,
        _where(diagnosis),
        _what(diagnosis),
        _how_far(diagnosis),
        tied=" ".join(filter(None, (_tied(diagnosis, cause) for cause in causes))),
        error=_error(diagnosis),
        left=_left(diagnosis) if causes else "",
        agreement=_agreement(causes),
        remedy=_remedy(causes),
    )


def _where(diagnosis: DiagnosisRecord) -> str:
    if not diagnosis.where and diagnosis.gap.unpredicted:
        return f"The gap shows in {words.listed(held_out(diagnosis))} alone."
    if not diagnosis.where:
        return "The diagnosis could not say where the gap lies."
    first = diagnosis.where[0]
    mainly = "" if first.share is not None and first.share > 0.95 else "mainly "
    said = f"The gap lies {mainly}in {words.location(first.location)}"
    if first.share is not None:
        said += f": {percent(first.share)} of it shows there"
    part = when(first.when or "")
    return f"{said}, {part}." if part else f"{said}."


def held_out(diagnosis: DiagnosisRecord) -> list[str]:
    """The recordings that were held out; two spans of one file have names of their own."""
    labels = [each.label for each in diagnosis.recordings if each.held_out]
    return labels or [*diagnosis.gap.held_out]


def when(text: str) -> str:
    """The part of the motion in which a gap shows, so that it can follow "it shows there,"."""
    said = re.sub(r"phi([12])", r"φ\1", text)
    said = re.sub(r"^column (above|below)", r"when the column's speed is \1", said)
    said = re.sub(r"^sliding (above|below)", r"when the rider slides \1", said)
    return said if not said or said.startswith(_STARTS) else f"when {said}"


def _what(diagnosis: DiagnosisRecord) -> str:
    causes, explained = diagnosis.accepted, diagnosis.verdict == "explained"
    if not causes and explained:
        return "The diagnosis does not name the cause."
    if not causes and diagnosis.gap.unpredicted:
        return (
            "What is missing shows in the held-out recordings alone, which the fitted ones do not "
            "predict; no cause can be asked for until some of them are fitted."
        )
    if not causes:
        return (
            "No effect of the catalogue explains it well enough to be named; the cause may lie "
            "outside the catalogue."
        )
    parts = [_cause(cause) for cause in causes]
    if not explained and _nothing_left(diagnosis):
        return (
            f"The likeliest {'cause' if len(parts) == 1 else 'causes'}: {'; '.join(parts)}; "
            "the fitted recordings show no structure beside."
        )
    if not explained:
        return f"Part of it comes from this: {'; '.join(parts)}."
    return f"The {'cause' if len(parts) == 1 else 'causes'}: {'; '.join(parts)}."


def _cause(cause: Cause) -> str:
    """Says what happens, with its id (unless that is all that is known of it) and probability."""
    more = [cause.effect] if words.clause(cause.effect) else []
    if cause.probability is not None:
        more.append(f"probability {probability(cause.probability)}")
    said = words.effect(cause.effect)
    return f"{said} ({', '.join(more)})" if more else said


def _tied(diagnosis: DiagnosisRecord, cause: Cause) -> str:
    others = diagnosis.tied_with(cause.effect)
    if not others:
        return ""
    return f"This data cannot tell {cause.effect} from {words.listed(others, 'or')}."


def _agreement(causes: Sequence[Cause]) -> str:
    """In how many recordings the first cause improves the fit, and where it makes it worse."""
    found = causes[0].agreement if causes else None
    if found is None or found.improved is None or found.of is None or found.of < 2:
        return ""
    name = causes[0].effect if len(causes) > 1 else "It"
    rest = f", and makes it worse in {words.listed([*found.worse])}" if found.worse else ""
    return f"{name} improves the fit in {found.improved:.0f} of {found.of:.0f} recordings{rest}."


def _remedy(causes: Sequence[Cause]) -> str:
    """Says what to do at the rig, and how to check by hand, a sentence each for every cause."""
    said = []
    for cause in causes:
        name = f"For {cause.effect}: " if len(causes) > 1 else ""
        if cause.remedy:
            said.append(f"{name}{cause.remedy if name else words.capital(cause.remedy)}.")
        if cause.by_hand:
            said.append(f"To check it by hand: {cause.by_hand}.")
    return " ".join(said)


def _how_far(diagnosis: DiagnosisRecord) -> str:
    gap, causes = diagnosis.gap, diagnosis.accepted
    if not causes and diagnosis.verdict == "unknown":
        return "Nothing was added to the model, so the gap stays as it is."
    if gap.shrink is None and gap.removable_significant is False:
        return "The gap on held-out data is too close to the noise to say how far it shrinks."
    if gap.shrink is None:
        return "How far the gap shrinks is not known."
    added = f"With {'them' if len(causes) > 1 else 'it'} in the model, " if causes else ""
    interval = percents(gap.shrink_ci95, negated=gap.shrink < 0.0)
    interval = f" (95 % interval {interval})" if interval else ""
    if gap.shrink < 0.0:
        return words.capital(
            f"{added}the gap on held-out data grew by {percent(-gap.shrink)} of what could be "
            f"removed{interval}."
        )
    return f"{added}{percent(gap.shrink)} of the removable gap is gone{interval}."


def _no_gap(diagnosis: DiagnosisRecord) -> str:
    p, limit = diagnosis.gap.structure_p, diagnosis.gap.tolerance
    test = f" (test of structure: {p_value(p)})" if p is not None else ""
    if _has_structure(p, _ALARM):  # the verdict is by the tolerance then
        given = f" of {angle(limit)}" if limit else ""
        return (
            f"What the fitted model leaves has structure{test}, but its error beyond the noise is "
            f"below the tolerance{given}."
        )
    return f"What the fitted model leaves of the recordings looks like noise{test}."


def _unseen(diagnosis: DiagnosisRecord) -> str:
    known = diagnosis.minimum_detectable
    small = "smaller than the minimum detectable sizes" if known else "too small for this data"
    return f"Effects {small} may be there all the same."


def _error(diagnosis: DiagnosisRecord) -> str:
    """The error on held-out data: of a free run, or in windows where that is not known."""
    before, after = diagnosis.gap.before, diagnosis.gap.after
    for kind, first, last in (
        ("of a free run", before.free_run, after.free_run),
        ("in short windows", before.windowed, after.windowed),
    ):
        if first is None:
            continue
        begin, end, noise = angles([first, last, diagnosis.floor])
        change = last is not None and diagnosis.accepted
        told = f"goes from {begin} to {end}" if change else f"is {begin}"
        rest = "" if diagnosis.floor is None else f"; the noise is {noise}"
        return f"The error {kind} over data never fitted {told}{rest}."
    return ""


def _has_structure(p: float | None, level: float = _LEVEL) -> bool:
    """True where a test of structure finds something; not known counts as nothing."""
    return p is not None and p < level


def _nothing_left(diagnosis: DiagnosisRecord) -> bool:
    """True where the test of structure finds nothing beside the causes."""
    p = diagnosis.gap.structure_p_after
    return p is not None and p >= _LEVEL


def _left(diagnosis: DiagnosisRecord) -> str:
    """Says that the model with its causes is not complete, where the test of structure says so."""
    p = diagnosis.gap.structure_p_after
    if not _has_structure(p):
        return ""
    small = "small " if diagnosis.verdict == "explained" else ""
    return f"What is left still has structure ({p_value(p)}): something {small}is missing yet."


def sizes(cause: Cause, says: str = "95 % interval ") -> list[str]:
    """The parameters of a cause, as `strength 0.580 (95 % interval 0.550 to 0.610)`.

    Of a learned law its curve: twelve coefficients tell nobody anything.

    says: before an interval.
    """
    if cause.curve is not None and cause.curve.y:
        low, high = min(cause.curve.y), max(cause.curve.y)
        said = [f"a curve from {number(low)} to {number(high)} {unit(cause.curve.y_unit)}".rstrip()]
        return [*said, f"as {cause.formula}"] if cause.formula else said
    said = []
    for name, given in cause.parameters.items():
        said.append(f"{name} {size(given.value, given.unit, given.ci95, says)}")
    return said


def chance_of_candidates(diagnosis: DiagnosisRecord) -> str:
    """Heading of the candidates' probabilities, which add up over the rounds once one is taken."""
    return "probability in any round" if diagnosis.accepted else "probability"


def next_experiment(diagnosis: DiagnosisRecord) -> str:
    """Says what to record next and why, in two sentences; empty where nothing is proposed."""
    plan = diagnosis.next_experiment
    if plan is None:
        return ""
    if plan.forced is False:
        said = "Record a free decay with the motor at rest"
        said += f", released at {angle(plan.phi1)}," if plan.phi1 is not None else ","
    elif plan.omega is not None:
        said = f"Drive the column at {plan.omega:.3g} rad/s"
    else:
        return ""
    separates = [*plan.separates]
    if not separates:
        return f"{said.rstrip(',')}."
    if len(separates) == 1:
        aim = f"settle {separates[0]}"
    elif len(separates) == 2:
        aim = f"tell {separates[0]} from {separates[1]}"
    else:
        aim = f"tell {words.listed(separates)} apart"
    sigma = plan.expected_sigma
    by = "" if sigma is None else f" (expected: {number(sigma, 2)} standard errors)"
    return f"{said} to {aim}{by}."
