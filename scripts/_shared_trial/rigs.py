"""Fleets of virtual rigs that share an effect, or none; the screen of each rig is saved."""

import dataclasses
import json
import tempfile
import time
from pathlib import Path

import numpy as np

from scripts._evidence.saving import SEED_OF_DRAWS, first_screen
from scripts._version import unchanged
from tp_jax._files import write_json
from tp_jax.rig import BENCH, make_campaign
from tp_jax.rig.effects import catalogue
from trials.detectable import minimum_detectable
from trials.draw import draw_rig, runs_of
from trials.projection import Bench

SEED = 46
"""Seed of the full fleets."""

RIGS = 12
"""Rigs of a fleet."""

PART = 0.5
"""Part of the size that the bench, recorded as the rigs are, just detects."""

FLEETS: tuple[str | None, ...] = ("spring_asymmetry", None, "contact_stribeck")
"""Effects that the rigs of each fleet share; None: nothing."""

RUNS, DURATION, RATE, NOISE = 6, 10.0, 250.0, 1e-3  # s, Hz, rad, as in the sealed trials


@dataclasses.dataclass(frozen=True)
class Row:
    """A rig.

    Attributes:
        fleet, rig: which it is, from 1 on. version: of the package that looked.
        effect: that the fleet shares, "" for none. sizes: its amplitudes.
        multiple: their size over the one that this rig's own screen would just detect.
        structure_p: that the rig alone shows nothing. first: the effect that takes most on it.
        tied: effects that its screen cannot tell from the shared one.
        chi2_dof: of the baseline. cpu_s: of the look [s].
    """

    fleet: int
    rig: int
    version: str
    effect: str
    sizes: tuple[float, ...]
    multiple: float | None
    structure_p: float
    first: str
    tied: tuple[str, ...]
    chi2_dof: float
    cpu_s: float


def file_of(folder: Path, fleet: int, rig: int) -> Path:
    """Names the file where the screen of a rig belongs."""
    return folder / f"fleet-{fleet:02d}-rig-{rig:02d}.npz"


def shared_effect(fleet: int) -> tuple[str, tuple[float, ...], dict[str, float]]:
    """Draws what a fleet shares: effect, sizes and shape constants; "" where it is nothing."""
    effect = FLEETS[fleet - 1]
    if effect is None:
        return "", (), {}
    draw = catalogue()[effect].draw(np.random.default_rng([SEED, fleet]), BENCH)
    bench = Bench(BENCH, runs_of(BENCH, RUNS, SEED), DURATION, RATE, NOISE, seed=SEED)
    factor = PART * minimum_detectable(bench, effect, draw.sizes, draw.shapes)
    return effect, tuple(float(factor * x) for x in draw.sizes), dict(draw.shapes)


def kept_effect(fleet: int, folder: Path) -> tuple[str, tuple[float, ...], dict[str, float]]:
    """The same, from a file of the folder where it is known already: half a minute to find."""
    file = folder / f"fleet-{fleet:02d}.json"
    if not file.is_file():
        folder.mkdir(parents=True, exist_ok=True)
        write_json(file, shared_effect(fleet))
    effect, sizes, shapes = json.loads(file.read_text(encoding="utf-8"))
    return effect, tuple(sizes), shapes


def look(fleet: int, rig: int, version: str, folder: Path) -> Row:
    """Makes a rig, saves its screen."""
    unchanged(version)
    from tp_jax.gap.detectability import TIED, cosine
    from tp_jax.gap.detectability import minimum_detectable as detectable
    from tp_jax.gap.shared.from_screen import rig_scores
    from tp_jax.gap.shared.scores import write

    effect, sizes, shapes = kept_effect(fleet, folder)
    parameters, seed, _ = draw_rig(np.random.default_rng([SEED, fleet, rig]), RUNS, DURATION)
    with tempfile.TemporaryDirectory() as place:
        campaign = Path(place) / "rig"
        make_campaign(
            campaign,
            parameters,
            {effect: sizes} if effect else {},
            shapes=shapes,
            runs=RUNS,
            rate=RATE,
            duration=DURATION,
            noise=NOISE,
            seed=seed,
        )
        begin = time.process_time()
        _, fit, seen, structure = first_screen(campaign)
    best = {s.id: s for s in seen.best()}
    tests = len(best)
    size = detectable(best[effect], tests, fit.chi2_dof) if effect in best else None
    tied = [
        id
        for id, s in best.items()
        if effect in best and id != effect and cosine(seen, s, best[effect]) > TIED
    ]
    name = f"rig-{rig:02d}"
    write(file_of(folder, fleet, rig), rig_scores(name, seen, (), SEED_OF_DRAWS))
    return Row(
        fleet,
        rig,
        version,
        effect,
        sizes,
        None if size is None else round(float(np.linalg.norm(sizes)) / size, 3),
        structure.p,
        seen.best()[0].id,
        tuple(tied),
        round(fit.chi2_dof, 4),
        round(time.process_time() - begin, 1),
    )
