"""Ours held against single peers, at equal error."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from .rows import Row, held, times

#: Both of CVODES' methods; ours is held against the faster, which is BDF only where bodies stick.
CVODES = ("casadi-cvodes", "casadi-adams")


def against(
    bar: str,
    where: tuple[str, str],
    found: Sequence[Mapping[str, Any]],
    names: Sequence[str],
    reached: Callable[[Mapping[str, Any]], bool],
) -> list[Row]:
    """A row that holds ours against the fastest of the peers `names`; none if none of them ran.

    Args:
        bar: key of `rows.BARS`.
        where: measure and case of the row.
        found: results, ours first, each with peer, error, seconds and ours_over_peer.
        names: peers that go as one.
        reached: whether a result has the error asked for; one that has not counts only where none
            of these peers has it, which the row then says.
    """
    able = [one for one in found if one["peer"] in names]
    if not able:
        return []
    there = [one for one in able if reached(one)]
    fastest = min(there or able, key=lambda one: one["seconds"]["median"])
    factor = fastest["ours_over_peer"]["median"]
    value = f"{times(factor)} {fastest['peer']}"
    if len(able) > 1:
        value += ", the faster of its two methods"
    if not there:
        value += f", whose error is {fastest['error']:.1e}"
    return [held(bar, *where, found[0]["peer"], factor, value)]
