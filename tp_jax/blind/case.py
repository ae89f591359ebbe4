"""One case: its campaign, the runs that are never given, and its part of the key."""

import dataclasses
import hashlib
import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from tp_jax.blind.detectable import minimum_detectable
from tp_jax.blind.draw import FARTHEST, applies, draw_rig, largest, runs_of, usable
from tp_jax.blind.plan import Case
from tp_jax.blind.projection import FREE, Bench
from tp_jax.recordings import CampaignError, load_campaign
from tp_jax.rig import RigParameters, make_campaign
from tp_jax.rig.effects import catalogue

SMALLEST, LARGEST = 1.0, 10.0  # times the minimum detectable size, uniform in the logarithm
ATTEMPTS = 20


@dataclasses.dataclass(frozen=True)
class Settings:
    """How every campaign of a trial is made.

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


def make_case(root: Path, case: Case, settings: Settings) -> dict[str, Any]:
    """Writes the recordings of a case, given and sealed ones; returns its part of the key.

    A case that was made before is not made again.
    """
    part = root / "sealed" / case.name / "key.json"
    if part.is_file():
        return json.loads(part.read_text(encoding="utf-8"))
    rng = np.random.default_rng(case.seed)
    for _ in range(ATTEMPTS):
        entry = _attempt(root, case, settings, rng)
        if entry is not None:
            part.write_text(json.dumps(entry, indent=1, allow_nan=False), encoding="utf-8")
            return entry
    raise RuntimeError(f"None of {ATTEMPTS} rigs gave a campaign for {case.name}.")


def _attempt(
    root: Path, case: Case, settings: Settings, rng: np.random.Generator
) -> dict[str, Any] | None:
    """A rig with its effects; None where their recordings are not usable."""
    parameters, seed, plan = draw_rig(rng, settings.runs, settings.duration)
    with_B2 = bool(rng.random() < 0.5)
    free = tuple(name for name in FREE if not (with_B2 and name == "B2"))
    bench = Bench(
        parameters, plan, settings.duration, settings.rate, settings.noise, free, seed
    )  # fmt: skip
    hidden, shapes, passed_over = _hide(case, bench, with_B2, rng)
    if len(hidden) < case.wanted:
        return None
    effects = {id: each["sizes"] for id, each in hidden.items()}
    common: dict[str, Any] = dict(
        effects=effects, shapes=shapes, rate=settings.rate, duration=settings.duration,
        noise=settings.noise, bits=settings.bits, with_B2=with_B2,
    )  # fmt: skip
    sealed_seed = _sealed_seed(parameters, settings, rng)
    folders = root / case.name, root / "sealed" / case.name
    made = [
        make_campaign(folder, parameters, runs=runs, seed=chance, **common)
        for folder, runs, chance in zip(
            folders, (settings.runs, settings.sealed_runs), (seed, sealed_seed), strict=True
        )
    ]
    if not all(map(_readable, folders)):
        return None
    return {
        "case": case.name,
        "kind": case.kind,
        "reference": {
            id: {"multiple": each["multiple"], "factor": each["factor"]}
            for id, each in hidden.items()
        },
        "passed_over": passed_over,
        "with_B2": with_B2,
        "given": made[0],
        "sealed": made[1],
        "sha256": {run["file"]: _sha256(folders[0] / run["file"]) for run in made[0]["runs"]},
    }


def _hide(
    case: Case, bench: Bench, with_B2: bool, rng: np.random.Generator
) -> tuple[dict[str, dict[str, Any]], dict[str, float], list[str]]:
    """The first preferred effects that this rig can show, sized; shapes; what was passed over."""
    hidden: dict[str, dict[str, Any]] = {}
    shapes: dict[str, float] = {}
    passed_over: list[str] = []
    for id in case.preferred:
        if len(hidden) == case.wanted:
            break
        draw = catalogue()[id].draw(rng, bench.parameters)
        level = math.log(LARGEST / SMALLEST) * rng.random()
        if not applies(id, with_B2):
            passed_over.append(id)
            continue
        factor = minimum_detectable(bench, id, draw.sizes, draw.shapes)
        most = largest(id, draw.sizes) / factor
        if most < SMALLEST:
            passed_over.append(id)
            continue
        # what would be implausibly large is drawn anew, up to what is plausible
        multiple = SMALLEST * math.exp(level)
        if multiple > most:
            multiple = SMALLEST * (most / SMALLEST) ** rng.random()
        hidden[id] = {
            "sizes": tuple(multiple * factor * x for x in draw.sizes),
            "multiple": multiple,
            "factor": factor,
        }
        shapes |= draw.shapes
    return hidden, shapes, passed_over


def _sealed_seed(parameters: RigParameters, settings: Settings, rng: np.random.Generator) -> int:
    """Seed of runs that are never given, in which the rider slides too."""
    for _ in range(ATTEMPTS):
        seed = int(rng.integers(2**31))
        plan = runs_of(parameters, settings.sealed_runs, seed)
        if usable(parameters, plan, settings.duration):
            break
    return seed


def _readable(folder: Path) -> bool:
    """Whether the package reads a campaign, and the column stays where springs bend."""
    try:
        campaign = load_campaign(folder)
    except CampaignError:
        return False
    return all(float(np.abs(r.phi1).max()) < FARTHEST for r in campaign.recordings)


def _sha256(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()
