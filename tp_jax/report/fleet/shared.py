"""Effects that the rigs of a fleet share, in sentences: the kind's effects, and some rigs' own."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from tp_jax.report import words
from tp_jax.report.formatting import MISSING, number, p_value, percent, size

KIND_HEAD, OWN_HEAD = "The kind's effects", "A rig's own"

MOST_NAMES = 6
"""Rigs that a sentence names; more are counted."""


class Said(NamedTuple):
    """An effect in words: its id, what it does, and the sentences that follow."""

    id: str
    does: str
    sentences: str


class Told(NamedTuple):
    """summary: a sentence on all; kind, own: effects that are named."""

    summary: str
    kind: list[Said]
    own: list[Said]


def told(shared: Mapping[str, Any]) -> Told:
    """Sentences on what a fleet's rigs share.

    Args:
        shared: as fleet.json has it under "shared".
    """
    if shared["reason"]:
        return Told(shared["reason"], [], [])
    kind, own = (
        [each for each in shared["effects"] if each["verdict"] == verdict]
        for verdict in ("kind", "own")
    )
    return Told(
        _summary(shared, len(kind)), [_kind(each) for each in kind], [_own(each) for each in own]
    )


def lines(shared: Mapping[str, Any]) -> list[str]:
    """The same for a terminal."""
    found = told(shared)
    said = [found.summary]
    for head, effects in ((KIND_HEAD, found.kind), (OWN_HEAD, found.own)):
        said += [f"{head}: {each.id}, {each.does}. {each.sentences}" for each in effects]
    return said


def _summary(shared: Mapping[str, Any], kinds: int) -> str:
    rigs = len(shared["rigs"])
    left = shared["left_out"]
    rest = f" {_names(left, '')} could not be asked." if left else ""
    if kinds:
        effects = "one effect" if kinds == 1 else f"{kinds} effects"
        return f"The {rigs} rigs share {effects}.{rest}"
    first = next(iter(shared["candidates"]), None)
    if shared["effects"] or first is None:
        return f"The {rigs} rigs share no effect that their recordings show.{rest}"
    return (
        f"The {rigs} rigs share no effect that their recordings show: noise alone gives as much as "
        f"the most likely one, {first['effect']}, with {p_value(first['p'])}.{rest}"
    )


def _kind(one: Mapping[str, Any]) -> Said:
    rest = one["without_largest"]
    left = rest["reduction"] / one["reduction"] if one["reduction"] else None
    sentences = [
        f"Its size is {_sizes(one)}, the same on all {one['asked_of']} rigs that it applies to.",
        f"Noise alone gives as much to any effect with {p_value(one['p'])}.",
        f"Without {rest['rig']}, which shows most of it, {percent(left)} of the evidence is left.",
        _alone(one),
        _tied(one),
    ]
    return Said(one["effect"], words.effect(one["effect"]), " ".join(filter(None, sentences)))


def _own(one: Mapping[str, Any]) -> Said:
    shown, asked = one["shown_by"], one["asked_of"]
    if shown:
        verb = "shows" if len(shown) == 1 else "show"
        first = f"{_names(shown, 'rig')} {verb} it, of {asked} rigs that it applies to."
    else:
        first = f"None of the {asked} rigs that it applies to shows it alone."
    differ = one["heterogeneity"]
    sentences = [
        first,
        f"The rigs do not agree on its size ({p_value(differ['p'])})."
        if one["differ"]
        else f"Without {one['without_largest']['rig']} too little of the evidence is left.",
        _tied(one),
    ]
    return Said(one["effect"], words.effect(one["effect"]), " ".join(filter(None, sentences)))


def _alone(one: Mapping[str, Any]) -> str:
    shown = one["shown_by"]
    if not shown:
        return "No rig shows it alone."
    return f"{_names(shown, 'rig')} {'shows' if len(shown) == 1 else 'show'} it alone."


def _tied(one: Mapping[str, Any]) -> str:
    others = one["confused_with"]
    return f"The fleet cannot tell it from {words.listed(others, 'or')}." if others else ""


def _names(rigs: Sequence[str], noun: str) -> str:
    if len(rigs) <= MOST_NAMES:
        return words.listed(list(rigs))
    return f"{len(rigs)} {noun or 'rig'}s"


def _sizes(one: Mapping[str, Any]) -> str:
    said = []
    for name, each in one["amplitudes"].items():
        said.append(f"{name} {size(each['value'], each['unit'], each['ci95'], '')}")
    shapes = [f"{name} {number(value)}" for name, value in one["shapes"].items()]
    return words.listed(said) + (f" at {words.listed(shapes)}" if shapes else "") or MISSING
