"""The verdict in three plain sentences: where the gap lies, what causes it, how far it shrinks."""

import re
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from tp_jax.report import reading, words
from tp_jax.report.formatting import (
    angle,
    angles,
    estimate,
    number,
    p_value,
    percent,
    percents,
    probability,
    unit,
)

_HEADINGS = {
    "explained": "The gap is explained",
    "no_gap": "No gap was found",
    "unknown": "There is a gap that is not explained",
}

_STARTS = (
    "when", "where", "while", "at ", "in ", "above", "below", "around", "near", "after", "before",
    "during", "throughout", "mainly", "mostly",
)  # fmt: skip

_LEVEL = 0.05  # of the test of structure


class Verdict(NamedTuple):
    """What a reader takes away.

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


def sentences(diagnosis: Mapping[str, Any]) -> Verdict:
    """The verdict of a diagnosis in words."""
    kind = reading.verdict(diagnosis)
    if not reading.text(diagnosis, "verdict"):
        return Verdict(
            "There is no verdict",
            "The diagnosis does not say whether there is a gap.",
            _what(diagnosis) if reading.causes(diagnosis) else "No cause is given.",
            _how_far(diagnosis),
            error=_error(diagnosis),
        )
    if kind == "no_gap":
        heading = _HEADINGS[kind]
        if not _beyond_level(diagnosis, "structure_p"):
            heading = "The gap is below the tolerance"
        said = heading, _no_gap(diagnosis), "No effect needs to be added to the model."
        return Verdict(*said, _unseen(diagnosis), error=_error(diagnosis))
    heading, causes = _HEADINGS[kind], reading.causes(diagnosis)
    if kind == "unknown" and causes:
        heading = "The gap is explained only in part"
        if _nothing_left(diagnosis):
            heading = "A cause was found, but not for certain how far the gap shrinks"
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


def _where(diagnosis: Mapping[str, Any]) -> str:
    places = reading.rows(diagnosis, "where")
    places = [place for place in places if reading.text(place, "location")]
    if not places:
        return "The diagnosis could not say where the gap lies."
    first = places[0]
    share = reading.value(first, "share")
    mainly = "" if share is not None and share > 0.95 else "mainly "
    said = f"The gap lies {mainly}in {words.location(reading.text(first, 'location'))}"
    if share is not None:
        said += f": {percent(share)} of it shows there"
    part = when(reading.text(first, "when"))
    return f"{said}, {part}." if part else f"{said}."


def when(text: str) -> str:
    """The part of the motion in which a gap shows, so that it can follow "it shows there,"."""
    said = re.sub(r"phi([12])", r"φ\1", text)
    said = re.sub(r"^column (above|below)", r"when the column's speed is \1", said)
    said = re.sub(r"^sliding (above|below)", r"when the rider slides \1", said)
    return said if not said or said.startswith(_STARTS) else f"when {said}"


def _what(diagnosis: Mapping[str, Any]) -> str:
    causes = reading.causes(diagnosis)
    if not causes and reading.verdict(diagnosis) == "explained":
        return "The diagnosis does not name the cause."
    if not causes:
        return (
            "No effect of the catalogue explains it well enough to be named; the cause may lie "
            "outside the catalogue."
        )
    parts = [_cause(cause) for cause in causes]
    if reading.verdict(diagnosis) != "explained" and _nothing_left(diagnosis):
        return (
            f"The likeliest {'cause' if len(parts) == 1 else 'causes'}: {'; '.join(parts)}; "
            "the fitted recordings show no structure beside."
        )
    if reading.verdict(diagnosis) != "explained":
        return f"Part of it comes from this: {'; '.join(parts)}."
    return f"The {'cause' if len(parts) == 1 else 'causes'}: {'; '.join(parts)}."


def _cause(cause: Mapping[str, Any]) -> str:
    """What happens, with its id (unless that is all that is known of it) and probability."""
    name = reading.text(cause, "effect")
    more = [name] if words.clause(name) else []
    if reading.value(cause, "probability") is not None:
        more.append(f"probability {probability(cause['probability'])}")
    return f"{words.effect(name)} ({', '.join(more)})" if more else words.effect(name)


def _tied(diagnosis: Mapping[str, Any], cause: Mapping[str, Any]) -> str:
    effect = reading.text(cause, "effect")
    others = reading.tied_with(diagnosis, effect)
    if not others:
        return ""
    return f"This data cannot tell {effect} from {words.listed(others, 'or')}."


def _agreement(causes: Sequence[Mapping[str, Any]]) -> str:
    """In how many recordings the first cause improves the fit, and where it makes it worse."""
    found = reading.table(causes[0], "agreement") if causes else {}
    improved, of = reading.value(found, "improved"), reading.value(found, "of")
    if improved is None or of is None or of < 2.0:
        return ""
    name = reading.text(causes[0], "effect") if len(causes) > 1 else "It"
    worse = reading.texts(found, "worse")
    rest = f", and makes it worse in {words.listed(worse)}" if worse else ""
    return f"{name} improves the fit in {improved:.0f} of {of:.0f} recordings{rest}."


def _remedy(causes: Sequence[Mapping[str, Any]]) -> str:
    """What to do at the rig, and how to check by hand, a sentence each for every cause."""
    said = []
    for cause in causes:
        remedy, by_hand = reading.text(cause, "remedy"), reading.text(cause, "by_hand")
        name = f"For {reading.text(cause, 'effect')}: " if len(causes) > 1 else ""
        if remedy:
            said.append(f"{name}{remedy if name else words.capital(remedy)}.")
        if by_hand:
            said.append(f"To check it by hand: {by_hand}.")
    return " ".join(said)


def _how_far(diagnosis: Mapping[str, Any]) -> str:
    gap, causes = reading.table(diagnosis, "gap"), reading.causes(diagnosis)
    shrink, interval = reading.value(gap, "shrink"), percents(gap.get("shrink_ci95"))
    if not causes and reading.text(diagnosis, "verdict") == "unknown":
        return "Nothing was added to the model, so the gap stays as it is."
    if shrink is None and gap.get("removable_significant") is False:
        return "The gap on held-out data is too close to the noise to say how far it shrinks."
    if shrink is None:
        return "How far the gap shrinks is not known."
    added = f"With {'them' if len(causes) > 1 else 'it'} in the model, " if causes else ""
    interval = f" (95 % interval {interval})" if interval else ""
    if shrink < 0.0:
        return words.capital(
            f"{added}the gap on held-out data grew by {percent(-shrink)} of what could be "
            f"removed{interval}."
        )
    return f"{added}{percent(shrink)} of the removable gap is gone{interval}."


def _no_gap(diagnosis: Mapping[str, Any]) -> str:
    p = reading.value(diagnosis, "gap", "structure_p")
    test = f" (test of structure: {p_value(p)})" if p is not None else ""
    if p is not None and p < _LEVEL:  # the verdict is by the tolerance then
        limit = reading.value(diagnosis, "gap", "tolerance")
        size = f" of {angle(limit)}" if limit else ""
        return (
            f"What the fitted model leaves has structure{test}, but its error is below the "
            f"tolerance{size}."
        )
    return f"What the fitted model leaves of the recordings looks like noise{test}."


def _unseen(diagnosis: Mapping[str, Any]) -> str:
    sizes = reading.table(diagnosis, "minimum_detectable")
    small = "smaller than the minimum detectable sizes" if sizes else "too small for this data"
    return f"Effects {small} may be there all the same."


def _error(diagnosis: Mapping[str, Any]) -> str:
    """The error on held-out data: of a free run, or in windows where that is not known."""
    gap, floor = reading.table(diagnosis, "gap"), reading.floor(diagnosis)
    for key, kind in (("free_run", "of a free run"), ("windowed", "in short windows")):
        before, after = reading.value(gap, "before", key), reading.value(gap, "after", key)
        if before is None:
            continue
        first, last, noise = angles([before, after, floor])
        change = after is not None and bool(reading.causes(diagnosis))
        size = f"goes from {first} to {last}" if change else f"is {first}"
        end = "" if floor is None else f"; the noise is {noise}"
        return f"The error {kind} over data never fitted {size}{end}."
    return ""


def _beyond_level(diagnosis: Mapping[str, Any], key: str) -> bool:
    """Whether a test of structure finds nothing; not known counts as nothing."""
    p = reading.value(diagnosis, "gap", key)
    return p is None or p >= _LEVEL


def _nothing_left(diagnosis: Mapping[str, Any]) -> bool:
    """Whether the test of structure finds nothing beside the causes."""
    known = reading.value(diagnosis, "gap", "structure_p_after") is not None
    return known and _beyond_level(diagnosis, "structure_p_after")


def _left(diagnosis: Mapping[str, Any]) -> str:
    """That the model with its causes is not complete, where the test of structure says so."""
    p = reading.value(diagnosis, "gap", "structure_p_after")
    if p is None or _nothing_left(diagnosis):
        return ""
    small = "small " if reading.verdict(diagnosis) == "explained" else ""
    return f"What is left still has structure ({p_value(p)}): something {small}is missing yet."


def sizes(cause: Mapping[str, Any]) -> list[str]:
    """The parameters of a cause, as `strength 0.580 (95 % interval 0.550 to 0.610)`.

    Of a learned law its curve: twelve coefficients tell nobody anything.
    """
    curve = reading.table(cause, "curve")
    if isinstance(curve.get("y"), list) and curve["y"]:
        low, high = min(curve["y"]), max(curve["y"])
        of = unit(reading.text(curve, "y_unit"))
        formula = reading.text(cause, "formula")
        said = [f"a curve from {number(low)} to {number(high)} {of}".rstrip()]
        return [*said, f"as {formula}"] if formula else said
    said = []
    for name, entry in reading.table(cause, "parameters").items():
        entry = reading.table(entry)
        size, interval = estimate(entry.get("value"), entry.get("ci95"))
        of = f" {unit(reading.text(entry, 'unit'))}".rstrip()
        interval = f" (95 % interval {interval})" if interval else ""
        said.append(f"{name} {size}{of}{interval}")
    return said


def next_experiment(diagnosis: Mapping[str, Any]) -> str:
    """What to record next and why, in one or two sentences; empty where nothing is proposed."""
    plan = reading.table(diagnosis, "next_experiment")
    omega, sigma = reading.value(plan, "omega"), reading.value(plan, "expected_sigma")
    separates = reading.texts(plan, "separates")
    if plan.get("forced") is False:
        release = reading.value(plan, "phi1")
        said = "Record a free decay with the motor at rest"
        said += f", released at {angle(release)}," if release is not None else ","
    elif omega is not None:
        said = f"Drive the column at {omega:.3g} rad/s"
    else:
        return ""
    if not separates:
        return f"{said.rstrip(',')}."
    if len(separates) == 1:
        aim = f"settle {separates[0]}"
    elif len(separates) == 2:
        aim = f"tell {separates[0]} from {separates[1]}"
    else:
        aim = f"tell {words.listed(separates)} apart"
    by = "" if sigma is None else f" (expected: {sigma:.2g} standard errors)"
    return f"{said} to {aim}{by}."
