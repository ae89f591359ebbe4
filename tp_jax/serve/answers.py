"""Answers of the page about the rig and its runs, as a browser sends them."""

import math
from collections.abc import Mapping
from typing import Any

from tp_jax.checks.proposal import Answers, Driven
from tp_jax.errors import InputError
from tp_jax.serve.limits import LIMITS

REMARK = "tp-jax serve writes this file. Remove this line to keep what you write into it yourself."
"""The first line of a campaign.toml that the page may replace."""


def answers_of(said: Any) -> Answers:
    """The answers in what was sent.

    Args:
        said: {"B1": text, "runs": {name: {"used": bool, "kind": text, "omega": text}}}.

    Raises:
        InputError: a sentence on the first field that cannot be used.
    """
    if not isinstance(said, Mapping) or not isinstance(said.get("runs"), Mapping):
        raise InputError("The answers have no runs; load the page anew.")
    B1 = _positive(said.get("B1", ""), "B1, the inertia of the column,")
    driven, unused = {}, set()
    for name, run in said["runs"].items():
        if not isinstance(run, Mapping):
            raise InputError(f"The answers for {name} are no table; load the page anew.")
        if not run.get("used", True):
            unused.add(name)
        else:
            driven[name] = _driven(name, run)
    if not driven:
        raise InputError("No recording is in use; tick one or more.")
    return Answers(B1, driven, frozenset(unused), REMARK)


def _driven(name: str, run: Mapping[str, Any]) -> Driven:
    kind = run.get("kind")
    if kind not in ("commanded", "measured", "decay"):
        raise InputError(f"{name}: choose how it was driven.")
    if kind != "commanded":
        return Driven(kind)
    omega = _positive(run.get("omega", ""), f"{name}: the frequency of its drive")
    if omega is None:
        raise InputError(
            f"{name}: the frequency of its drive is missing; type it in rad/s, or choose free "
            "decay."
        )
    if not LIMITS.slowest <= omega <= LIMITS.fastest:
        raise InputError(
            f"{name}: the frequency of its drive must be from {LIMITS.slowest:g} to "
            f"{LIMITS.fastest:g} rad/s, but is {omega:g}."
        )
    return Driven(kind, omega)


def _positive(text: Any, what: str) -> float | None:
    """A number above zero; None where nothing was typed. A decimal comma is one too."""
    typed = str(text).strip()
    if not typed:
        return None
    try:
        value = float(typed.replace(",", "."))
    except ValueError:
        value = math.nan
    if not 0.0 < value < math.inf:
        raise InputError(f"{what} must be a number above zero, but is {typed[:40]!r}.")
    return value
