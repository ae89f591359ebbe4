"""Draws rigs and saves the first screen of each; what a diagnosis does after it is left out."""

import dataclasses
import os
import sys
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from scripts._evidence import screens
from scripts._evidence.screens import Saved, Variant
from tp_jax.executors import ExecutorChoice, Piece, run_pieces

if TYPE_CHECKING:
    from tp_jax.estimation.fitted import Fit
    from tp_jax.estimation.prepared_campaign import PreparedCampaign
    from tp_jax.gap.screen import Screen
    from tp_jax.gap.structure import Structure

SEED = 38
"""Seed of the study; no choice of the diagnosis was made on its rigs."""

PARTS = {
    "clean": {"none": 4, "one": 6, "two": 1, "outside": 1},
    "rough": {"none": 4, "one": 4, "cousin": 3, "outside": 1},
}
"""Rigs of twelve: a third hides nothing."""

NICENESS = 19  # a study that waits for whatever else the machine has to do
LAST = 6  # rigs of a process; its compiled programs add up
SEED_OF_DRAWS = 0  # as in a diagnosis


@dataclasses.dataclass(frozen=True)
class Facts:
    """A rig, and what today's rules say of it.

    Attributes:
        number, rigs, kind, seed: which rig it is, and the seed of all chance in it.
        hidden: id -> location, channel and multiple: size over the detectable one, as the rig has
            it. cousins: id -> the effect of the catalogue that it is like.
        chi2_dof, cost, dof: of the baseline. coloured: whether its noise is.
        rounded: whether readings are rounded more coarsely than they are noisy.
        floor_error: relative error of the noise's variance.
        structure_p, free_p, excess, combined_p: of today's tests that anything is there.
        windows, samples: how much was fitted. cpu_s: of the look [s].
    """

    number: int
    rigs: str
    kind: str
    seed: int
    hidden: dict[str, dict[str, Any]]
    cousins: dict[str, str]
    chi2_dof: float
    cost: float
    dof: int
    coloured: bool
    rounded: bool
    floor_error: float
    structure_p: float
    free_p: float
    excess: float
    combined_p: float
    windows: int
    samples: int
    cpu_s: float


def file_of(folder: Path, rigs: str, number: int) -> Path:
    """Names the file where the screen of a rig belongs."""
    return folder / f"{rigs}-{number:05d}.npz"


def save_all(folder: Path, wanted: dict[str, int], until: float) -> int:
    """Saves the screens that are not there yet, one after another; the exit code.

    Args:
        folder: where to.
        wanted: rigs of each kind, numbered from 1.
        until: on `time.monotonic`; no rig is begun after it.
    """
    os.nice(NICENESS)
    folder.mkdir(parents=True, exist_ok=True)
    every = [(number, rigs) for rigs, count in wanted.items() for number in range(1, count + 1)]
    # the kinds by turns, in proportion, so that a part of the study is a fair part
    every.sort(key=lambda task: task[0] / wanted[task[1]])
    left = [
        Piece(f"{rigs}-{number}", (folder, number, rigs))
        for number, rigs in every
        if screens.read(file_of(folder, rigs, number)) is None
    ]
    status = 0
    one = ExecutorChoice("local", 1)
    for ended in run_pieces(save, left, one, until=until, pieces_per_worker=LAST):
        fault = ended.fault
        told = f"is saved, {ended.result:.0f} CPU s" if fault is None else f"failed: {fault}"
        print(f"evidence: {ended.piece.key} {told}.", file=sys.stderr, flush=True)
        status = status if fault is None else 1
    return status


def save(folder: Path, number: int, rigs: str) -> float:
    """Makes a rig and saves its screen; CPU seconds."""
    from trials.case import Settings, make_case
    from trials.growing import rig
    from trials.rough import RoughSettings

    case = rig(number, SEED, rigs, PARTS[rigs])
    settings = RoughSettings() if rigs == "rough" else Settings()
    with tempfile.TemporaryDirectory() as place:
        entry = make_case(Path(place), case, settings)
        begin = time.process_time()
        saved = look(Path(place) / case.name)
    spent = round(time.process_time() - begin, 1)
    known = {
        "number": number,
        "rigs": rigs,
        "kind": case.kind,
        "seed": case.seed,
        "cpu_s": spent,
        "hidden": {
            id: {
                "location": each["location"],
                "channel": each["channel"],
                "multiple": entry["reference"][id]["multiple"],
            }
            for id, each in entry["given"]["effects"].items()
        },
        "cousins": {id: of["of"] for id, of in (entry.get("cousins") or {}).items()},
    }
    facts = dataclasses.asdict(Facts(**known, **saved.facts))
    screens.write(file_of(folder, rigs, number), dataclasses.replace(saved, facts=facts))
    return spent


def first_screen(campaign: Path) -> tuple["PreparedCampaign", "Fit", "Screen", "Structure"]:
    """A campaign as the first round of its diagnosis sees it."""
    from tp_jax.estimation.drive_errors import with_drives_of_angles
    from tp_jax.estimation.prepared_campaign import prepare_campaign
    from tp_jax.estimation.schedule import fit_over_schedule
    from tp_jax.estimation.start import initial_values
    from tp_jax.gap.choice import looked_at
    from tp_jax.gap.known_noise import with_noise_of
    from tp_jax.gap.policy import POLICY
    from tp_jax.gap.refit import Refit, refit_with_sharp_friction
    from tp_jax.recordings import hold_out, load_campaign

    setting = prepare_campaign(hold_out(load_campaign(campaign)))
    baseline = fit_over_schedule(setting, initial_values(setting), setting.unknowns())
    setting, baseline = with_drives_of_angles(setting, baseline)
    if baseline.chi2_dof < POLICY.noise.below:
        setting, baseline = with_noise_of(setting, baseline, baseline)
    current = Refit(baseline, ())
    fit, seen, structure = looked_at(
        setting, current, refit_with_sharp_friction(setting, current), SEED_OF_DRAWS
    )
    return setting, fit, seen, structure


def look(campaign: Path) -> Saved:
    """The first screen of a campaign's diagnosis; `facts` are those that it tells itself."""
    from tp_jax.estimation.fitted import parameter
    from tp_jax.gap.free_structure import free_scores, free_structure
    from tp_jax.gap.held_out import floor_error
    from tp_jax.gap.structure import scores_of_noise
    from tp_jax.gap.verdict import combined

    setting, fit, seen, structure = first_screen(campaign)
    free_p = free_structure(setting, fit).p
    error = floor_error(setting)
    excess = float((fit.chi2_dof - 1.0) / np.hypot(error, np.sqrt(2.0 / max(fit.dof, 1))))
    facts = {
        "chi2_dof": fit.chi2_dof,
        "cost": fit.cost,
        "dof": fit.dof,
        "coloured": bool(fit.problem.coloured),
        "rounded": seen.rounding is not None,
        "floor_error": error,
        "structure_p": structure.p,
        "free_p": free_p,
        "excess": excess,
        "combined_p": combined(structure.p, free_p, excess),
        "windows": fit.problem.windows.n,
        "samples": int(fit.problem.windows.count.sum()),
    }
    specs = [parameter(fit.problem, u) for s in seen.scored for u in s.variant.unknowns]
    blocks = np.zeros((len(seen.by_block.H), len(seen.total)))
    for s in seen.scored:
        blocks[: len(s.blocks), s.rows] = s.blocks
    noise = [drawn.sum(axis=0) for drawn in scores_of_noise(seen, SEED_OF_DRAWS)]
    scores = free_scores(setting, fit)
    names = list(dict.fromkeys(str(name) for name in scores.source))
    parts = [scores.of(name) for name in names]
    return Saved(
        facts=facts,
        variants=tuple(
            Variant(
                s.id,
                s.variant.effect.location,
                dict(s.variant.shapes),
                s.rows.start,
                s.rows.stop - s.rows.start,
                s.drop,
            )
            for s in seen.scored
        ),
        score=seen.total,
        information=seen.information,
        typical=np.array([spec.typical for spec in specs]),
        limits=np.array([(spec.lower, spec.upper) for spec in specs]).reshape(-1, 2),
        blocks=blocks,
        by_block=seen.by_block.dense(),
        noise=np.concatenate(noise, axis=1),
        sources=tuple(names),
        ends=np.cumsum([value.size for value, _ in parts]),
        variance=np.concatenate([value.ravel() for value, _ in parts]),
        free=np.concatenate([z.ravel() for _, z in parts]),
    )
