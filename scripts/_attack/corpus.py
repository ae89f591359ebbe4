"""Valid inputs, small, to begin from."""

import dataclasses
import json
from pathlib import Path

import numpy as np

from scripts._attack import small
from tp_jax.recordings.calibration import Calibration, SensorCalibration, calibration_entry, to_toml
from tp_jax.schemas.recording import VERSION as RECORDING

CAMPAIGN = """\
name = "bench"
[rig]
model = "double"
B1 = 1.2e-3
B2 = { value = 5.0e-4, sd = 5.0e-5 }
sample_rate = 100.0
[[recording]]
file = "decay.csv"
forced = false
[[recording]]
file = "run-13.csv"
omega = 13.0
forced = true
start = 120.0
repeat = "A"
held_out = true
span = [0.0, 0.55]
[[recording]]
file = "run-13.csv"
omega = 13.0
forced = true
span = [0.6, 1.19]
"""

RUNS = ("decay.csv", "run-13.csv")

FORMAT = """\
name = "theirs"
[rig]
model = "single"
[format]
delimiter = "\\t"
decimal = ","
skip_lines = 2
[format.columns]
t = { column = 0 }
phi1 = { column = 2, scale = 0.5, offset = 0.01 }
drive = { column = 3, offset = -2.57 }
[[recording]]
file = "theirs.txt"
forced = true
drive = "measured"
"""


def motion(n: int = 120, rate: float = 100.0, seed: int = 0) -> np.ndarray:
    """(n, 3) times and two angles that look like a run."""
    t = np.arange(n) / rate
    noise = np.random.default_rng(seed).normal(0.0, 1e-3, (2, n))
    return np.column_stack(
        [t, 0.5 * np.sin(9.0 * t) + noise[0], 0.3 * np.sin(9.0 * t - 0.4) + noise[1]]
    )


def recording(seed: int = 0) -> bytes:
    """CSV of a run."""
    rows = "\n".join(",".join(f"{x:.9g}" for x in row) for row in motion(seed=seed))
    return f"t,phi1,phi2\n{rows}\n".encode()


def theirs() -> bytes:
    """A file of another make, with a measured drive."""
    rows = "\n".join(
        "\t".join(f"{x:.6f}".replace(".", ",") for x in (t, 7.0, a, 2.57 + b))
        for t, a, b in motion()
    )
    return f"a rig\nin volts\n{rows}\n".encode()


def calibration() -> Calibration:
    """Makes a calibration of both sensors, by two laws."""
    p = SensorCalibration(
        "sine_cosine",
        np.array([1.65, 2.6, 1.64, 2.58, 0.01]),
        np.diag([2e-3] * 5) ** 2,
        (-0.7, 0.7),
        0.003,
    )
    line = SensorCalibration("line", np.array([1.65, 2.6]), np.diag([1e-3, 2e-2]) ** 2)
    return Calibration({"phi1": p, "phi2": line}, "rig.toml")


def calibration_text() -> bytes:
    """Its file."""
    return to_toml(calibration()).encode()


def readings() -> bytes:
    """Volts at known angles, from which a calibration is made."""
    angle = np.linspace(-0.7, 0.7, 15)
    volts = 1.65 + 1.3 * np.sin(2.0 * angle), 1.64 + 1.29 * np.cos(2.0 * angle)
    rows = "\n".join(f"{a:.6g},{s:.6g},{c:.6g}" for a, s, c in zip(angle, *volts, strict=True))
    return f"phi1,sine1,cosine1\n{rows}\n".encode()


def metadata() -> dict:
    """Makes the metadata of a recording, as far as they are read back."""
    entry = calibration_entry(calibration(), {"phi1": (-0.5, 0.5), "phi2": (-0.5, 0.5)})
    content = {"schema": RECORDING, "state": "complete", "calibration": entry}
    return json.loads(json.dumps(content, default=lambda x: x.tolist()))


def starts() -> dict:
    """Two starts of a search."""
    done = {
        "x": [0.45, 1e-3],
        "cost": 12.0,
        "chi2_dof": 1.0,
        "information": [[1.0, 0.0], [0.0, 1.0]],
        "evaluations": 9,
        "converged": True,
        "message": "Done.",
        "objective": 12.0,
        "states": [[0.0] * 4] * 3,
    }
    failed = done | {"cost": None, "chi2_dof": None, "objective": None, "states": None}
    key = {"seed": 0, "data": {"a.csv": "12"}, "bounds": {"k": [0.1, 1.0]}}
    return {"key": key, "done": {"start 0": done, "end 0": failed}}


def part_of_key() -> dict:
    """Makes what a sealed trial keeps of one case."""
    effect = {
        "sizes": {"a": 0.1},
        "shapes": {},
        "unit": ["1"],
        "location": "column",
        "channel": "column",
        "in_catalogue": True,
    }
    return {
        "case": "case-001",
        "kind": "one",
        "reference": {"column_tilt": {"multiple": 4.0}},
        "sha256": {"run-01.csv": "ab"},
        "given": {
            "effects": {"column_tilt": effect},
            "parameters": {"k": 0.45},
            "runs": [{"file": "run-01.csv", "release": 0.5, "values": {}}],
        },
    }


def text_stream() -> bytes:
    """Lines of a rig that sends text."""
    return b"".join(b"%.4f %.5f %.5f\n" % tuple(row) for row in motion(60))


def frames() -> bytes:
    """Frames of a rig that speaks the protocol."""
    from tp_jax.acquisition import protocol

    return b"".join(protocol.sample(1, i, 1000 * i, (i, 7 * i, 0, 65535)) for i in range(60))


@dataclasses.dataclass(frozen=True)
class Folder:
    """Valid files in a folder, for commands to be pointed at."""

    root: Path

    def made(self) -> "Folder":
        """Writes them."""
        rig = self.root / "rig"
        rig.mkdir(parents=True)
        (rig / "campaign.toml").write_text(CAMPAIGN)
        for seed, name in enumerate(RUNS):
            (rig / name).write_bytes(recording(seed))
        (self.root / "diagnosis.json").write_text(json.dumps(small.diagnosis()))
        (self.root / "rig.toml").write_bytes(calibration_text())
        (self.root / "volts.csv").write_bytes(readings())
        (self.root / "spoiled").write_bytes(b"\xff\0[")
        return self
