"""The rigs of a study that grows: an endless row of them, each known by its number."""

import dataclasses
from collections.abc import Mapping

from trials.plan import RIGS, Case, plan_cases

STRIDE = 1 << 20
"""Plans of one study; the seeds of the next begin beyond them."""

PLANNED = {"clean": 44, "rough": 36}
"""Rigs of a plan: the fewest in which `plan.RIGS` comes out in whole numbers (a tenth of them)."""


def rig(
    number: int, seed: int, rigs: str = "clean", parts: Mapping[str, int] | None = None
) -> Case:
    """The rig with a number, the same for the same arguments.

    Args:
        number: from 1 on.
        seed: of the study.
        rigs: one of `RIGS`.
        parts: how many of each kind a plan has, if not as `RIGS` has them in `PLANNED` rigs.

    Returns:
        What is to be made; `case.make_case` makes it.
    """
    size = PLANNED[rigs] if parts is None else sum(parts.values())
    which, place = divmod(number - 1, size)
    case = plan_cases(size, seed * STRIDE + which, rigs, parts or RIGS[rigs])[place]
    return dataclasses.replace(case, name=f"{rigs}-{number:05d}")
