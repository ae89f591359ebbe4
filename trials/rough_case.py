"""One case of a rough rig."""

import math
from pathlib import Path
from typing import Any

import numpy as np

from tp_jax.rig import RigParameters
from tp_jax.rig.effects import catalogue
from trials.effects.base import Outside
from trials.hiding import hide, reference
from trials.plan import Case
from trials.projection import FREE, Bench
from trials.recorded import record_campaign
from trials.recorder import Recorder
from trials.rough import (
    RIDER,
    Kind,
    RoughSettings,
    draw_kind,
    draw_parameters,
    draw_recorder,
)
from trials.rough_runs import Run, center, draw_runs, sealed_runs, shows
from trials.written import readable, sha256

DRAWS = 400  # of a rig until one shows its motion


def attempt(
    root: Path, case: Case, settings: RoughSettings, rng: np.random.Generator
) -> dict[str, Any] | None:
    """A rig with its effects, written; None where their recordings are not usable."""
    kind = draw_kind(rng, settings)
    found = _draw_rig(rng, settings, kind)
    if found is None:
        return None
    parameters, recorder, plan, sealed = found
    seed, sealed_seed = (int(rng.integers(2**31)) for _ in range(2))
    bench = bench_of(parameters, recorder, plan, settings, seed)
    driven = kind.driven
    hidden, shapes, passed_over = hide(
        case, bench, lambda id: tellable(id, recorder, driven, kind.rider), rng
    )
    if len(hidden) < case.wanted:
        return None
    effects = {id: each["sizes"] for id, each in hidden.items()}
    folders = root / case.name, root / "sealed" / case.name
    made = [
        record_campaign(folder, parameters, effects, shapes, runs, recorder, chance)
        for folder, runs, chance in zip(folders, (plan, sealed), (seed, sealed_seed), strict=True)
    ]
    if not all(map(readable, folders)):
        for folder in folders:  # another rig has another number of runs
            for file in folder.glob("run-*.csv"):
                file.unlink()
        return None
    return {
        "case": case.name,
        "kind": case.kind,
        "rigs": "rough",
        "reference": reference(hidden),
        "passed_over": passed_over,
        "cousins": {
            id: {"of": effect.cousin_of, "family": effect.family}
            for id in hidden
            for effect in (catalogue()[id],)
            if isinstance(effect, Outside) and effect.cousin_of
        },
        "with_B2": recorder.with_B2,
        # the campaign's unit of torque, as its diagnosis has it [N m]
        "unit_torque": 1.0 if recorder.with_B1 else parameters.B1,
        "given": made[0],
        "sealed": made[1],
        "sha256": {run["file"]: sha256(folders[0] / run["file"]) for run in made[0]["runs"]},
    }


def _draw_rig(
    rng: np.random.Generator, settings: RoughSettings, kind: Kind
) -> tuple[RigParameters, Recorder, list[Run], list[Run]] | None:
    """Numbers, recorder, given and sealed runs of a rig that shows what it does."""
    for _ in range(DRAWS):
        parameters = draw_parameters(rng, settings, kind)
        recorder = draw_recorder(rng, settings, kind, parameters.A)
        noise = max(recorder.sensor1.rms, recorder.sensor2.rms if kind.rider else 0.0)
        plan = draw_runs(rng, settings, kind, parameters)
        sealed = sealed_runs(rng, settings, kind, plan)
        if shows(parameters, plan, noise) and shows(parameters, sealed, noise, sliding=0.0):
            return parameters, recorder, plan, sealed
    return None


def bench_of(
    p: RigParameters, recorder: Recorder, plan: list[Run], settings: RoughSettings, seed: int
) -> Bench:
    """Returns what decides how small an effect the campaign shows, from a part of its runs.

    The noise is white noise of the sensor's spectral density at frequency zero, or of its
    variance if that is more; motions are slow against the sampling. What a measured drive reads
    wrong counts as noise of phi1, as of a column that follows its spring (at resonance it is more).
    """
    drive = 0.0
    if recorder.drive is not None:
        drive = math.hypot(recorder.drive.noise, 2.0 * math.pi / 2**recorder.drive.bits / 3.5)
    one = math.hypot(max(recorder.sensor1.slow, recorder.sensor1.rms), drive)
    two = max(recorder.sensor2.slow, recorder.sensor2.rms)
    taken: list[Run] = []
    for run in [plan[i] for i in np.random.default_rng([seed, 8]).permutation(len(plan)).tolist()]:
        time = sum(each["duration"] for each in taken) + run["duration"]
        if not taken or (len(taken) < settings.looked_at and time <= settings.looked_for):
            taken.append(run)
    if any("omega" in run for run in plan) and not any("omega" in run for run in taken):
        taken.append(min((r for r in plan if "omega" in r), key=lambda r: r["duration"]))
    absent = (() if p.has_rider else RIDER) + (("B2",) if recorder.with_B2 else ())
    return Bench(
        p,
        taken,
        rate=recorder.rate,
        noise=one,
        seed=seed,
        free=tuple(name for name in FREE if name not in absent),
        window=settings.periods * 2.0 * math.pi / center(p),
        per_run=settings.per_run,
        weights=(1.0, two / one),
        cousins_by_kind=True,
        part=sum(r["duration"] for r in taken) / sum(r["duration"] for r in plan),
    )


def tellable(id: str, recorder: Recorder, driven: bool, rider: bool) -> bool:
    """True if an effect can be known from recordings of a kind at all."""
    effect = catalogue()[id]
    if effect.needs_rider and not rider:
        return False
    if id == "reaction_factor":  # no angle shows it unless both moments of inertia are given
        return recorder.with_B2
    # what the motor does is read where its angle is, and has no scale of time but the recorder's
    commanded = driven and recorder.drive is None
    return commanded or not (effect.location == "drive" or id == "clock_skew")
