"""Reading a diagnosis: any of its entries may be missing or null, and none may break the report."""

import math
from collections.abc import Mapping
from typing import Any

from tp_jax.report.formatting import finite

CHANNELS = {"phi1": "φ1", "phi2": "φ2"}


def table(of: Any, *keys: str) -> Mapping[str, Any]:
    """The table below these keys; empty where there is none."""
    for key in keys:
        of = of.get(key) if isinstance(of, Mapping) else None
    return of if isinstance(of, Mapping) else {}


def rows(of: Any, key: str) -> list[Mapping[str, Any]]:
    """The tables listed below this key."""
    return [row for row in _list(of, key) if isinstance(row, Mapping)]


def texts(of: Any, key: str) -> list[str]:
    """The texts listed below this key."""
    return [entry for entry in _list(of, key) if isinstance(entry, str) and entry]


def text(of: Any, key: str) -> str:
    """The text below this key, or an empty one."""
    value = of.get(key) if isinstance(of, Mapping) else None
    return "" if value is None else str(value)


def value(of: Any, *keys: str) -> float | None:
    """The finite number below these keys."""
    return finite(table(of, *keys[:-1]).get(keys[-1]))


def verdict(diagnosis: Mapping[str, Any]) -> str:
    """explained, no_gap or unknown; unknown where nothing is said."""
    said = text(diagnosis, "verdict")
    return said if said in ("explained", "no_gap") else "unknown"


def groups(diagnosis: Mapping[str, Any]) -> list[list[str]]:
    """Groups of effects that this data cannot tell apart, two or more in each."""
    found = [
        group for group in _list(diagnosis, "confused_with") if isinstance(group, list | tuple)
    ]
    named = [[str(name) for name in group if name] for group in found]
    return [group for group in named if len(group) > 1]


def tied_with(diagnosis: Mapping[str, Any], effect: str) -> list[str]:
    """The others of all groups in which this effect is."""
    others = [name for group in groups(diagnosis) if effect in group for name in group]
    return [name for name in dict.fromkeys(others) if name != effect]


def causes(diagnosis: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Accepted causes that have a name."""
    return [row for row in rows(diagnosis, "causes") if text(row, "effect")]


def candidates(diagnosis: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Candidates that apply to this campaign, most probable first."""
    named = [row for row in rows(diagnosis, "candidates") if text(row, "effect")]
    return [row for row in named if row.get("applicable") is not False]


def judged(candidate: Mapping[str, Any]) -> bool:
    """Whether anything is known of a candidate."""
    keys = ("predicted_shrink", "realised_shrink", "probability", "z")
    return any(value(candidate, key) is not None for key in keys) or bool(text(candidate, "note"))


def inapplicable(diagnosis: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Candidates that do not apply to this campaign."""
    named = [row for row in rows(diagnosis, "candidates") if text(row, "effect")]
    return [row for row in named if row.get("applicable") is False]


def recorded(diagnosis: Mapping[str, Any]) -> list[str]:
    """First and last day on which its recordings were made, once where they are the same.

    Empty where their metadata do not say.
    """
    days = [text(row, "started")[:10] for row in rows(diagnosis, "recordings")]
    known = sorted(filter(None, days))
    return list(dict.fromkeys([known[0], known[-1]])) if known else []


def states(diagnosis: Mapping[str, Any]) -> tuple[str, ...]:
    """before and after; before alone where nothing was added, or no error after is known."""
    after = table(diagnosis, "gap", "after")
    known = any(finite(size) is not None for size in after.values())
    return ("before", "after") if known and causes(diagnosis) else ("before",)


def floor(diagnosis: Mapping[str, Any]) -> float | None:
    """Noise floor over the channels [rad]: the root of the mean of their squares."""
    found = [value(diagnosis, "noise_floor", channel) for channel in CHANNELS]
    squares = [x * x for x in found if x is not None]
    return math.sqrt(sum(squares) / len(squares)) if squares else None


def _list(of: Any, key: str) -> list[Any]:
    found = of.get(key) if isinstance(of, Mapping) else None
    return list(found) if isinstance(found, list | tuple) else []
