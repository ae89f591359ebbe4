"""One diagnosis against the truth.

A group of effects that the diagnosis calls confused with each other, of three at most, counts as
one: naming any of them is naming the true one. `top1_alone` is without that allowance.
`undetectable`: the diagnosis says that no size of what is hidden, or of one of two, shows; such a
case counts among all sizes and in no band of them.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from trials import truth

MOST_TIED = 3

Diagnosis = Mapping[str, Any]


def judge(entry: Mapping[str, Any], diagnosis: Diagnosis) -> dict[str, Any]:
    """Says what a diagnosis got right; None where a question does not arise.

    Args:
        entry: the case's part of the key. diagnosis: as in diagnosis.json.
    """
    hidden = list(entry["given"]["effects"])
    causes = [cause["effect"] for cause in diagnosis.get("causes") or []]
    where = diagnosis.get("where") or []
    multiples = {id: truth.multiple(entry, id, diagnosis) for id in hidden}
    known = [value for value, _ in multiples.values() if value is not None]
    row: dict[str, Any] = {
        "case": entry["case"],
        "kind": entry["kind"],
        "effects": hidden,
        "multiple": min(known) if known and len(known) == len(hidden) else None,
        "multiples": {id: {"value": v, "scale": scale} for id, (v, scale) in multiples.items()},
        "verdict": diagnosis["verdict"],
        "causes": causes,
        "top1": None,
        "top1_alone": None,
        "top3": None,
        "location": None,
        "channel": None,
        "false_alarm": None,
        "unknown": None,
        "both_named": None,
        "one_named": None,
        "explained": None,
        "undetectable": None,
        "cousin": None,
        "cousin_location": None,
        "first": None,
        "coverage": truth.covered(entry, diagnosis) if entry["kind"] in ("one", "none") else None,
    }
    row["first"] = first_cause(entry, diagnosis)
    if entry["kind"] == "none":
        row["false_alarm"] = diagnosis["verdict"] != "no_gap" or bool(causes)
        return row
    row["channel"] = bool(where) and where[0].get("channel") in truth.channels(entry)
    if entry["kind"] == "cousin":
        (id,) = hidden
        row["cousin"] = bool(causes) and names_cousin(entry, id, diagnosis)
        same = _places(entry["cousins"][id]["of"], diagnosis, truth.location(entry, id))
        row["cousin_location"] = bool(where) and where[0].get("location") in same
        return row
    if entry["kind"] != "outside":
        row["explained"] = diagnosis["verdict"] == "explained"
        row["undetectable"] = row["multiple"] is None
    if entry["kind"] == "outside":
        row["unknown"] = diagnosis["verdict"] == "unknown"
    elif entry["kind"] == "one":
        (id,) = hidden
        row["top1_alone"] = causes[:1] == [id]
        row["top1"] = bool(causes) and causes[0] in tied(diagnosis, id)
        row["top3"] = among_first(diagnosis, id, 3)
        row["location"] = bool(where) and where[0].get("location") in _places(
            id, diagnosis, truth.location(entry, id)
        )
    else:
        row["both_named"] = both_named(diagnosis, hidden)
        row["one_named"] = any(cause in tied(diagnosis, id) for cause in causes for id in hidden)
    return row


def tied(diagnosis: Diagnosis, id: str) -> set[str]:
    """An effect and those that count as the same."""
    groups = diagnosis.get("confused_with") or []
    return {id}.union(*(group for group in groups if id in group and len(group) <= MOST_TIED))


def among_first(diagnosis: Diagnosis, id: str, n: int) -> bool:
    """True if an effect is among the first n: accepted causes, then candidates by probability.

    Those tied with one that was counted already are not counted again.
    """
    ranked = [cause["effect"] for cause in diagnosis.get("causes") or []]
    ranked += [
        row["effect"]
        for row in diagnosis.get("candidates") or []
        if row.get("applicable", True) and row["effect"] not in ranked
    ]
    counted: list[set[str]] = []
    for each in ranked:
        if any(each in group for group in counted):
            continue
        if len(counted) == n:
            break
        counted.append(tied(diagnosis, each))
    return any(id in group for group in counted)


def both_named(diagnosis: Diagnosis, hidden: Sequence[str]) -> bool:
    """True if two different causes stand for the two hidden effects."""
    causes = [cause["effect"] for cause in diagnosis.get("causes") or []]
    one, two = (tied(diagnosis, id) for id in hidden)
    return any(a != b and a in one and b in two for a in causes for b in causes)


def said(row: Mapping[str, Any]) -> str:
    """Puts a diagnosis of a case in a word: its first cause, `no_gap` or `unknown`.

    Of what lies outside the catalogue the verdict `unknown` is the answer, whatever takes a part
    of the gap.
    """
    if row["verdict"] == "no_gap" or (row["kind"] == "outside" and row["verdict"] == "unknown"):
        return row["verdict"]
    return row["causes"][0] if row["causes"] else str(row["verdict"])


def first_cause(entry: Mapping[str, Any], diagnosis: Diagnosis) -> dict[str, Any] | None:
    """Probability that a diagnosis states of its first cause, and whether that is right.

    Right is what is hidden or tied with it, and the kind of a cousin. Where nothing is hidden no
    cause is right; outside the catalogue only a law learned in the channel where it acts.
    """
    causes = diagnosis.get("causes") or []
    if not causes or not isinstance(causes[0].get("probability"), int | float):
        return None
    hidden = list(entry["given"]["effects"])
    if entry["kind"] == "cousin":
        right = names_cousin(entry, hidden[0], diagnosis)
    elif entry["kind"] == "outside":
        learned = causes[0].get("kind") == "learned"
        right = learned and causes[0].get("channel") in truth.channels(entry)
    else:
        right = any(causes[0]["effect"] in tied(diagnosis, id) for id in hidden)
    return {"probability": float(causes[0]["probability"]), "right": bool(right)}


def names_cousin(entry: Mapping[str, Any], id: str, diagnosis: Diagnosis) -> bool:
    """True if the first cause is a cousin's kind, tied with it, or a learned law of its family."""
    known, cause = entry["cousins"][id], diagnosis["causes"][0]
    if cause.get("kind") == "learned":
        said = str(cause.get("family") or cause["effect"])
        return _family(said) == _family(known["family"])
    return cause["effect"] in tied(diagnosis, known["of"])


def _family(name: str) -> tuple[str, str]:
    """Place and argument of a law: which of a place's torques it multiplies does not matter."""
    place, _, argument = name.partition(".")
    return place.partition("_")[0], argument


def _places(id: str, diagnosis: Diagnosis, location: str) -> set[str]:
    """A location, and those of effects tied with one that is there."""
    known = {row["effect"]: row.get("location") for row in diagnosis.get("candidates") or []}
    same = {known[other] for other in tied(diagnosis, id) if known.get(other)}
    return {location, *same}
