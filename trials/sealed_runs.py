"""Measures how far a diagnosis closes the gap on runs never given, and how far it could.

Windowed as in the diagnosis itself (`gap.held_out`): the sealed runs are its held-out recordings.
The best possible is the true model, its effects, amplitudes and shape constants known to begin
with, refitted to the fitted recordings of the case.
"""

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tp_jax.effects import get
from tp_jax.estimation.layout import Values
from tp_jax.estimation.prepared_campaign import PreparedCampaign, prepare_campaign
from tp_jax.estimation.schedule import fit_over_schedule
from tp_jax.estimation.start import initial_values
from tp_jax.gap.directions import variants
from tp_jax.gap.held_out import evaluate, shrink
from tp_jax.gap.refit import refit, refit_with_sharp_friction
from tp_jax.recordings import Campaign, load_campaign
from trials import truth
from trials.kept import kept
from trials.schema import SHRINK
from trials.seal import diagnosis_file

SHORTEST = 0.5  # s: windows of a diagnosis that does not say how long they were
ITERATIONS = 12


def measured(
    root: Path, entry: Mapping[str, Any], diagnosis: Mapping[str, Any]
) -> dict[str, float | None]:
    """Shrink of the diagnosis and of the true model on the sealed runs of a case.

    shrink: None where the sealed runs show no significant gap. best: 1 where the catalogue lacks
    one of the hidden effects, None where its fit fails. Kept beside the diagnosis, and read from
    there the next time.
    """
    file = diagnosis_file(root, entry["case"])
    return kept(
        file.with_name("sealed.json"), file, SHRINK, lambda: _measure(root, entry, diagnosis)
    )


def _measure(
    root: Path, entry: Mapping[str, Any], diagnosis: Mapping[str, Any]
) -> dict[str, float | None]:
    held_out = diagnosis["gap"].get("held_out") or []
    setting = prepare_campaign(together(root, entry["case"], held_out), model=diagnosis["model"])
    horizon = float(diagnosis["gap"].get("horizon_s") or SHORTEST)
    seed = int((diagnosis.get("provenance") or {}).get("seed") or 0)
    before = evaluate(setting, numbers(setting, diagnosis["fits"]["before"]), horizon)
    record = diagnosis["fits"]["after"]
    reached: float | None = 0.0
    if record is not None:
        effects = [get(id) for id in record["effects"]]
        after = evaluate(setting, numbers(setting, record), horizon, effects)
        reached = shrink(setting, before, after, seed).value
    if not shrink(setting, before, before, seed).significant:
        return {"shrink": None, "best": None}
    true = true_model(setting, entry, horizon)
    best = 1.0 if true is None else shrink(setting, before, true, seed).value
    return {"shrink": reached, "best": best}


def together(root: Path, case: str, held_out: list[str]) -> Campaign:
    """The fitted recordings of a case, and its sealed runs as those that are held out."""
    given = load_campaign(root / case)
    fitted = tuple(r for r in given.recordings if r.name not in held_out)
    sealed = tuple(
        dataclasses.replace(r, name=f"sealed-{r.name}", label=f"sealed-{r.label}", held_out=True)
        for r in load_campaign(root / "sealed" / case).recordings
    )
    return dataclasses.replace(given, recordings=(*fitted, *sealed))


def numbers(setting: PreparedCampaign, record: Mapping[str, Any]) -> Values:
    """The numbers of a fit in diagnosis.json, for the recordings of a setting."""
    labels = [r.label for r in setting.recordings]
    index = setting.layout.index
    changes: dict[str, Any] = {n: x for n, x in record["parameters"].items() if n in index}
    changes |= {"reaction": record["reaction"], "eps1": record["eps"], "eps2": record["eps"]}
    # the zero of phi2 is estimated anew for a run that was not fitted
    changes |= {n: x for n, x in record["nuisances"].items() if n != "zero2"}
    changes["zero2"] = _by_recording(record["nuisances"]["zero2"], labels)
    for id, values in record["effects"].items():
        effect = get(id)
        changes |= {effect.qualified(name): x for name, x in effect.constants.items()}
        for name, x in values.items():
            each = _by_recording(x, labels) if isinstance(x, Mapping) else x
            changes[effect.qualified(name)] = each
    return initial_values(setting).replace({n: x for n, x in changes.items() if n in index})


def _by_recording(values: Mapping[str, float], labels: list[str]) -> list[float]:
    return [float(values.get(label, 0.0)) for label in labels]


def true_model(setting: PreparedCampaign, entry: Mapping[str, Any], horizon: float):
    """Windowed errors on the sealed runs of the true model, refitted; None without such a model."""
    given = entry["given"]
    known = {e.id: e for e in setting.layout.effects}
    if not set(given["effects"]) <= set(known):
        return None
    index = setting.layout.index
    p = {n: x for n, x in truth.parameters(entry).items() if n in index}
    known_too = {n: x for n, x in nuisances(entry).items() if n in index}
    values = initial_values(setting).replace(p | known_too | setting.fixed)
    found = []
    for id, hidden in given["effects"].items():
        effect = known[id]
        variant = variants(effect, setting)[0]
        shapes = tuple((name, float(hidden["shapes"].get(name, x))) for name, x in variant.shapes)
        variant = dataclasses.replace(variant, shapes=shapes)
        values = values.replace(variant.settings | _amplitudes(setting, entry, id))
        found.append(variant)
    begun = fit_over_schedule(
        setting, values, setting.unknowns(), horizons=(horizon,), max_iterations=3
    )
    done = refit_with_sharp_friction(
        setting, refit(setting, begun, found, max_iterations=ITERATIONS)
    )
    return evaluate(setting, done.fit.values, horizon, [v.effect for v in found])


def nuisances(entry: Mapping[str, Any]) -> dict[str, float]:
    """Phase of the drive, zero of phi1, and how a measured drive's reading is to be read."""
    recorder = entry["given"].get("recorder") or {}
    zero1 = (recorder.get("sensor1") or {}).get("zero", 0.0)
    out = {"phase": 0.0, "zero1": zero1}
    drive = recorder.get("drive")
    if drive is not None:  # the arm is (reading - offset) / gain
        out |= {"gain": 1.0 / drive["gain"], "level": zero1 - drive["offset"] / drive["gain"]}
    return out


def _amplitudes(setting: PreparedCampaign, entry: Mapping[str, Any], id: str) -> dict[str, Any]:
    """True amplitudes by slot; one for each recording where runs differ."""
    given, known = entry["given"], truth.sizes(entry, id)
    names = list(known)
    of_runs = {run["file"]: run["values"][id] for run in given["runs"] if id in run["values"]}
    if not of_runs:
        return {f"{id}.{name}": size for name, size in known.items()}
    nothing = [0.0] * len(names)
    table = [of_runs.get(r.name, nothing) for r in setting.recordings]
    return {f"{id}.{name}": [row[i] for row in table] for i, name in enumerate(names)}
