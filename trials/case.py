"""One case: its campaign, the runs that are never given, and its part of the key."""

import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np

from tp_jax._files import replaced
from tp_jax.errors import InputError
from tp_jax.rig import RigParameters, make_campaign
from tp_jax.schemas.checking import check, read_json
from trials.draw import applies, draw_rig, runs_of, usable
from trials.hiding import LARGEST as LARGEST
from trials.hiding import SMALLEST as SMALLEST
from trials.hiding import hide, reference
from trials.plan import Case
from trials.projection import FREE, Bench
from trials.rough import RoughSettings
from trials.rough_case import attempt
from trials.schema import CASE
from trials.written import readable, sha256

ATTEMPTS = 20

PART_OF_KEY = "key.json"
"""File in a case's sealed folder, until the trial is whole."""


@dataclasses.dataclass(frozen=True)
class Settings:
    """Settings by which every campaign of a trial is made.

    Attributes:
        runs: given; the first a decay. sealed_runs: never given.
        rate: samples a second. duration: of a run [s].
        noise: standard deviation of a reading [rad]. bits: of the converter.
    """

    runs: int = 6
    sealed_runs: int = 3
    rate: float = 250.0
    duration: float = 10.0
    noise: float = 1e-3
    bits: int = 16


def make_case(root: Path, case: Case, settings: Settings | RoughSettings) -> dict[str, Any]:
    """Writes the recordings of a case, given and sealed ones; returns its part of the key.

    A case that was made before is not made again.
    """
    part = root / "sealed" / case.name / PART_OF_KEY
    if part.is_file():
        try:
            known = read_json(part)
            check(known, CASE, str(part))
            return known
        except InputError:  # half a file, say: the same case is made anew from its seed
            part.unlink()
    rng = np.random.default_rng(case.seed)
    for _ in range(ATTEMPTS):
        if isinstance(settings, RoughSettings):
            entry = attempt(root, case, settings, rng)
        else:
            entry = _attempt(root, case, settings, rng)
        if entry is not None:
            with replaced(part) as file:
                file.write_text(json.dumps(entry, indent=1, allow_nan=False), encoding="utf-8")
            return entry
    raise RuntimeError(f"None of {ATTEMPTS} rigs gave a campaign for {case.name}.")


def _attempt(
    root: Path, case: Case, settings: Settings, rng: np.random.Generator
) -> dict[str, Any] | None:
    """A rig with its effects; None where their recordings are not usable."""
    parameters, seed, plan = draw_rig(rng, settings.runs, settings.duration)
    with_B2 = bool(rng.random() < 0.5)
    free = tuple(name for name in FREE if not (with_B2 and name == "B2"))
    bench = Bench(parameters, plan, settings.duration, settings.rate, settings.noise, free, seed)
    hidden, shapes, passed_over = hide(case, bench, lambda id: applies(id, with_B2), rng)
    if len(hidden) < case.wanted:
        return None
    effects = {id: each["sizes"] for id, each in hidden.items()}
    common: dict[str, Any] = dict(
        effects=effects,
        shapes=shapes,
        rate=settings.rate,
        duration=settings.duration,
        noise=settings.noise,
        bits=settings.bits,
        with_B2=with_B2,
    )
    sealed_seed = _sealed_seed(parameters, settings, rng)
    folders = root / case.name, root / "sealed" / case.name
    made = [
        make_campaign(folder, parameters, runs=runs, seed=chance, **common)
        for folder, runs, chance in zip(
            folders, (settings.runs, settings.sealed_runs), (seed, sealed_seed), strict=True
        )
    ]
    if not all(map(readable, folders)):
        return None
    return {
        "case": case.name,
        "kind": case.kind,
        "reference": reference(hidden),
        "passed_over": passed_over,
        "with_B2": with_B2,
        "given": made[0],
        "sealed": made[1],
        "sha256": {run["file"]: sha256(folders[0] / run["file"]) for run in made[0]["runs"]},
    }


def _sealed_seed(parameters: RigParameters, settings: Settings, rng: np.random.Generator) -> int:
    """Seed of runs that are never given, in which the rider slides too."""
    for _ in range(ATTEMPTS):
        seed = int(rng.integers(2**31))
        plan = runs_of(parameters, settings.sealed_runs, seed)
        if usable(parameters, plan, settings.duration):
            break
    return seed
