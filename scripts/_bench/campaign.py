"""A campaign of the virtual rig with the preset's numbers, and the same for `scipy_script`."""

import dataclasses
import importlib.util
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

import tp_jax as tp
from tp_jax.estimation.free_runs import FreeRuns
from tp_jax.model.parameters import DEFAULT_EPS
from tp_jax.rig import RigParameters, make_campaign

from .bench import Bench

NOISE = 1e-3  # rad
#: What (17) knows nothing of: the sine's phase is the commanded one, and the sensors' zeros too.
KNOWN = {"phase": 0.0, "zero1": 0.0}


def made(runs: int, duration: float, seed: int = 0) -> Any:
    """Recordings of a rig with hard friction, the first a decay."""
    with tempfile.TemporaryDirectory() as folder:
        make_campaign(
            Path(folder, "rig"),
            RigParameters(),
            runs=runs,
            duration=duration,
            noise=NOISE,
            seed=seed,
        )
        return tp.load_campaign(Path(folder, "rig"))


def truth() -> dict[str, float]:
    """The rig's numbers by name."""
    return dataclasses.asdict(RigParameters())


def cvodes_tolerance(b: Bench) -> float | None:
    """Tolerance of CVODES for the error asked for, if it is among peers; None without CasADi."""
    if importlib.util.find_spec("casadi") is None:
        return None
    peers = [peer for peer in b.peers if peer.name == "casadi-cvodes"]
    return b.tolerance(peers[0], DEFAULT_EPS)[0] if peers else 1e-8


def as_plain(setting: Any, tol: float) -> Any:
    """The fitted recordings as the SciPy script takes them, from the same first states."""
    from .scipy_script import Runs

    which, states = setting.fitted, FreeRuns(setting).states
    data = [setting.prepared[r] for r in which]
    return Runs(
        ts=np.asarray(data[0].t),
        readings=np.stack([d.y for d in data]),
        states=np.stack([states[r] for r in which]),
        omega=np.array([setting.recordings[r].omega or 0.0 for r in which]),
        B1=setting.campaign.B1,
        noise=NOISE,
        eps=DEFAULT_EPS,
        tol=tol,
    )
