"""Truth of a case, in the terms of its diagnosis."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

#: Numbers of a rig that are in proportion to its torques.
TORQUES = ("B1", "B2", "k", "c1", "M1", "Tv", "Ts1", "Tst")


def channels(entry: Mapping[str, Any]) -> set[str]:
    """Channels in which the hidden effects show."""
    return {effect["channel"] for effect in entry["given"]["effects"].values()}


def location(entry: Mapping[str, Any], id: str) -> str:
    """Returns where a hidden effect is."""
    return entry["given"]["effects"][id]["location"]


def unit_torque(entry: Mapping[str, Any]) -> float:
    """Unit of the campaign's torques and moments of inertia [N m]; 1 where it gives B1.

    A campaign without B1 has it as 1, and everything else in proportion.
    """
    return float(entry.get("unit_torque", 1.0))


def parameters(entry: Mapping[str, Any]) -> dict[str, float]:
    """The rig's numbers, in the units of the campaign."""
    unit = unit_torque(entry)
    return {
        name: x / unit if name in TORQUES else x for name, x in entry["given"]["parameters"].items()
    }


def sizes(entry: Mapping[str, Any], id: str) -> dict[str, float]:
    """Amplitudes of a hidden effect, in the units of the campaign."""
    effect = entry["given"]["effects"][id]
    scales = _scales(entry, id)
    return {n: x / y for (n, x), y in zip(effect["sizes"].items(), scales, strict=True)}


def _scales(entry: Mapping[str, Any], id: str) -> list[float]:
    effect = entry["given"]["effects"][id]
    units = list(effect.get("unit") or ["1"])
    units += units[-1:] * (len(effect["sizes"]) - len(units))
    return [unit_torque(entry) if unit.startswith("N m") else 1.0 for unit in units]


def size(entry: Mapping[str, Any], id: str, diagnosis: Mapping[str, Any]) -> float:
    """Length of a hidden effect's vector of amplitudes, in its unit.

    Where every run has amplitudes of its own, of those in the fitted runs; less their mean, where
    only the differences matter.
    """
    effect = entry["given"]["effects"][id]
    held_out = (diagnosis.get("gap") or {}).get("held_out") or []
    values = [
        run["values"][id]
        for run in entry["given"]["runs"]
        if id in run["values"]
        and run["file"] not in held_out
        # a motor that stands has no frequency
        and ("omega" in run or effect["location"] != "drive")
    ]
    if not values:
        return math.hypot(*sizes(entry, id).values())
    table = np.array(values) / np.array(_scales(entry, id))
    if id == "contact_repeatability":
        table = table - table.mean(axis=0)
    return float(np.linalg.norm(table))


def multiple(
    entry: Mapping[str, Any], id: str, diagnosis: Mapping[str, Any]
) -> tuple[float | None, str]:
    """Size over the minimum detectable one, and by whose scale that is.

    Of an effect of the catalogue the diagnosis' own ("diagnosis"); None where it says that no size
    shows in these recordings. Of one from outside it that which was measured on the rig when the
    case was made ("reference").
    """
    if not entry["given"]["effects"][id]["in_catalogue"]:
        return float(entry["reference"][id]["multiple"]), "reference"
    least = ((diagnosis.get("minimum_detectable") or {}).get(id) or {}).get("value")
    return (size(entry, id, diagnosis) / least if least else None), "diagnosis"


def covered(entry: Mapping[str, Any], diagnosis: Mapping[str, Any]) -> dict[str, list[bool]]:
    """Says whether intervals hold the truth: of the amplitudes, and of the rig's parameters.

    Asked only where the model that was found is the true one, effect by effect.
    """
    hidden = entry["given"]["effects"]
    causes = {cause["effect"]: cause for cause in diagnosis.get("causes") or []}
    out: dict[str, list[bool]] = {"amplitudes": [], "parameters": []}
    if set(causes) != set(hidden):
        return out
    for id, cause in causes.items():
        for name, true in sizes(entry, id).items():
            _ask(out["amplitudes"], (cause.get("parameters") or {}).get(name), true)
    for name, true in parameters(entry).items():
        _ask(out["parameters"], (diagnosis.get("parameters") or {}).get(name), true)
    return out


def _ask(answers: list[bool], estimate: Mapping[str, Any] | None, true: float) -> None:
    if not estimate or not isinstance(estimate.get("value"), int | float):
        return
    ends = estimate.get("ci95")
    if ends and estimate.get("identifiable", True) and None not in ends and ends[0] < ends[1]:
        answers.append(bool(ends[0] <= true <= ends[1]))
