"""A campaign of runs that are given one by one, as a recorder writes it, and the key to it."""

import dataclasses
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tp_jax.recordings import write_csv
from tp_jax.rig.parameters import RigParameters
from tp_jax.rig.recording_key import hidden_effects, values_by_run
from tp_jax.rig.simulator import VirtualRig
from trials.recorder import Recorder

Run = Mapping[str, float]


def record_campaign(
    directory: str | os.PathLike[str],
    parameters: RigParameters,
    effects: Mapping[str, float | Sequence[float]] | None,
    shapes: Mapping[str, float] | None,
    plan: Sequence[Run],
    recorder: Recorder,
    seed: int,
) -> dict[str, Any]:
    """Writes the recordings of a rig and a campaign.toml that tells nothing of what is hidden.

    Args:
        directory: where to; made if it is not there. Its name is the campaign's.
        parameters, effects, shapes: as `VirtualRig` takes them.
        plan: of every run "omega" [rad/s] or "release" [rad], its "duration" [s], and "swing", by
            which the amplitude of the drive is multiplied (1 if absent).
        recorder: how it is recorded. seed: of everything random.

    Returns:
        The key, plain data for JSON, with the fields of `make_campaign`'s as far as they apply.
    """
    rig = VirtualRig(parameters, effects, seed, shapes)
    values = values_by_run(rig, plan)
    rng = np.random.default_rng([seed, 2])
    folder = Path(directory)
    folder.mkdir(parents=True, exist_ok=True)
    files = [f"run-{i + 1:02d}.csv" for i in range(len(plan))]
    for file, run, own in zip(files, plan, values, strict=True):
        ts = np.arange(round(run["duration"] * recorder.rate) + 1) / recorder.rate
        ideal, arm = follow(rig, run, ts, own, metered=recorder.drive is not None)
        write_csv(
            folder / file,
            ts,
            recorder.sensor1.read(ideal[:, 0], rng),
            recorder.sensor2.read(ideal[:, 1], rng) if parameters.has_rider else None,
            None if recorder.drive is None else recorder.drive.read(arm, rng),
        )
    toml = _toml(folder.resolve().name, parameters, recorder, files, plan)
    (folder / "campaign.toml").write_text(toml, encoding="utf-8")
    return {
        "effects": hidden_effects(rig),
        "parameters": dataclasses.asdict(parameters),
        "recorder": dataclasses.asdict(recorder),
        "seed": seed,
        "runs": [
            {"file": file, **run, "values": {id: list(v) for id, v in own.items()}}
            for file, run, own in zip(files, plan, values, strict=True)
        ],
    }


def begin(rig: VirtualRig, run: Run, run_values: Mapping[str, Sequence[float]] | None = None):
    """Starts one run of a plan."""
    rig.amplitude = rig.parameters.A * run.get("swing", 1.0)
    rig.start(
        omega=run.get("omega"),
        release=run.get("release"),
        duration=run["duration"],
        run_values=run_values,
    )


def follow(
    rig: VirtualRig,
    run: Run,
    ts: np.ndarray,
    run_values: Mapping[str, Sequence[float]] | None = None,
    *,
    metered: bool = False,
) -> tuple[np.ndarray, np.ndarray]:
    """A run of a plan: what ideal sensors report (n, 2), and the motor's arm (n,) [rad].

    The arm stays at zero unless it is `metered`.
    """
    begin(rig, run, run_values)
    read, arm = np.empty((ts.size, 2)), np.zeros(ts.size)
    for i, t in enumerate(ts.tolist()):
        true = rig.true_time(t)
        read[i] = rig.advance(true)
        if metered:
            arm[i] = rig.arm(true)
    return read, arm


def _toml(
    name: str, p: RigParameters, recorder: Recorder, files: Sequence[str], plan: Sequence[Run]
) -> str:
    text = name.replace("\\", "\\\\").replace('"', '\\"')
    lines = [f'name = "{text}"', "", "[rig]"]
    if not p.has_rider:
        lines.append('model = "single"')
    if recorder.with_B1:
        lines.append(f"B1 = {p.B1:.9e}  # kg m^2, column inertia from CAD")
    if recorder.with_B2 and p.has_rider:
        lines.append(f"B2 = {p.B2:.9e}  # kg m^2, rider inertia from CAD")
    lines.append(f"sample_rate = {float(recorder.rate)}  # Hz")
    for file, run in zip(files, plan, strict=True):
        forced = "omega" in run
        lines += ["", "[[recording]]", f'file = "{file}"']
        if forced and recorder.drive is None:
            lines.append(f"omega = {run['omega']}  # rad/s, commanded")
        lines.append(f"forced = {'true' if forced else 'false'}")
        if recorder.drive is not None and (forced or recorder.decays_metered):
            lines.append('drive = "measured"')
    return "\n".join(lines) + "\n"
