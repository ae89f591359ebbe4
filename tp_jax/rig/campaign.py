"""A campaign of a virtual rig, as files, and the key to it."""

import dataclasses
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tp_jax.errors import InputError
from tp_jax.recordings import write_csv
from tp_jax.rig.chain import measure
from tp_jax.rig.parameters import BENCH, RigParameters
from tp_jax.rig.plan import plan_runs
from tp_jax.rig.recording_key import hidden_effects, values_by_run
from tp_jax.rig.simulator import VirtualRig


def make_campaign(
    directory: str | os.PathLike[str],
    parameters: RigParameters = BENCH,
    effects: Mapping[str, float | Sequence[float]] | None = None,
    *,
    shapes: Mapping[str, float] | None = None,
    runs: int = 6,
    rate: float = 250.0,
    duration: float = 10.0,
    noise: float = 1e-3,
    bits: int = 16,
    seed: int = 0,
    with_B2: bool = False,
    measured: bool = False,
) -> dict[str, Any]:
    """Writes the recordings of a rig with hidden effects, and a campaign.toml that tells nothing.

    Args:
        directory: where to; made if it is not there. Its name is the campaign's.
        parameters, effects, shapes: as `VirtualRig` takes them.
        runs: number of recordings, the first a decay, the others driven.
        rate: samples a second of the recorder's clock. duration: of a recording [s].
        noise: standard deviation of a reading [rad]. bits: of the converter.
        seed: of everything random.
        with_B2: the campaign gives the rider's moment of inertia as well as the column's.
        measured: the drive of each driven run is recorded, without noise, and its frequency is not
            told; always so where drive_delay is hidden, which shows in nothing else.

    Returns:
        The key, plain data for JSON: what is hidden, with sizes, shape constants and values of
        each run; parameters; how the runs were made.

    Raises:
        InputError: an argument cannot be used.
        OSError: a file cannot be written.
    """
    if runs < 2:
        raise InputError(f"A campaign needs at least 2 runs, not {runs}.")
    if not (rate > 0.0 and duration * rate >= 10.0):
        raise InputError(f"A run of {duration:g} s at {rate:g} Hz has too few samples.")
    if not (noise >= 0.0 and 4 <= bits <= 32):
        raise InputError("The noise must be zero or more, and the converter have 4 to 32 bits.")
    rig = VirtualRig(parameters, effects, seed, shapes)
    measured = measured or "drive_delay" in rig.effects
    plan = plan_runs(parameters, runs, np.random.default_rng([seed, 1]))
    values = values_by_run(rig, plan)
    rng = np.random.default_rng([seed, 2])
    ts = np.arange(round(duration * rate) + 1) / rate
    folder = Path(directory)
    folder.mkdir(parents=True, exist_ok=True)
    files = [f"run-{i + 1:02d}.csv" for i in range(runs)]
    for file, kind, own in zip(files, plan, values, strict=True):
        ideal = rig.run(
            ts,
            omega=kind.get("omega"),
            release=kind.get("release"),
            duration=duration,
            run_values=own,
        )
        phi1, phi2 = measure(ideal, rng, noise=noise, bits=bits).T
        arm = None
        if measured and "omega" in kind:
            arm = [rig.read_drive(t) for t in rig.taken]
        write_csv(folder / file, ts, phi1, phi2 if parameters.has_rider else None, arm)
    toml = _toml(folder.resolve().name, parameters, rate, files, plan, with_B2, measured)
    (folder / "campaign.toml").write_text(toml, encoding="utf-8")
    return {
        "effects": hidden_effects(rig),
        "parameters": dataclasses.asdict(parameters),
        "noise": noise,
        "bits": bits,
        "rate": rate,
        "duration": duration,
        "seed": seed,
        "runs": [
            {"file": file, **kind, "values": {id: list(v) for id, v in own.items()}}
            for file, kind, own in zip(files, plan, values, strict=True)
        ],
    }


def _toml(
    name: str,
    p: RigParameters,
    rate: float,
    files: Sequence[str],
    plan: Sequence[Mapping[str, float]],
    with_B2: bool,
    measured: bool,
) -> str:
    text = name.replace("\\", "\\\\").replace('"', '\\"')
    lines = [f'name = "{text}"', "", "[rig]"]
    if not p.has_rider:
        lines.append('model = "single"')
    lines.append(f"B1 = {p.B1:.9e}  # kg m^2, column inertia from CAD")
    if with_B2 and p.has_rider:
        lines.append(f"B2 = {p.B2:.9e}  # kg m^2, rider inertia from CAD")
    lines.append(f"sample_rate = {float(rate)}  # Hz")
    for file, kind in zip(files, plan, strict=True):
        forced = "omega" in kind
        lines += ["", "[[recording]]", f'file = "{file}"']
        if forced and measured:
            lines.append('drive = "measured"')
        else:
            lines.append(f"omega = {kind.get('omega', 0.0)}  # rad/s, commanded")
        lines.append(f"forced = {'true' if forced else 'false'}")
    return "\n".join(lines) + "\n"
