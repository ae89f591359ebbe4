"""Section 5.2 on a virtual rig: recordings that the printed model cannot meet.

The paper's recordings were never published. The rig here has hard dry friction and some of the
effects that the paper's Section 6 suspects; the program that looks for its parameters knows of none
of them, as the paper's did not.
"""

from typing import Any

import numpy as np

from scripts._paper import nelder_mead, windows
from scripts._paper.objective import LISTING_START, ORDER, Objective, motion
from scripts._paper.scale import Scale
from tp_jax.rig import BENCH, VirtualRig

OMEGA = 2.0 * np.pi / 0.48  # rad/s, as measured in the paper
NOISE = 1e-3  # rad
RATE = 250.0  # Hz
#: A friction that drops once the rider slides, and that differs from run to run.
EFFECTS = {"contact_stribeck": 0.5, "contact_repeatability": 0.15}
PAPER = (0.01171, 0.05328)  # y at the end of the paper's two identifications


def run(scale: Scale, tell) -> dict[str, Any]:
    """Both identifications, each of a recording of its own."""
    recordings = measured(scale)
    out: dict[str, Any] = {
        "effects": EFFECTS,
        "omega": OMEGA,
        "paper_y": PAPER,
        "identifications": [],
    }
    for i, objective in enumerate(recordings):
        tell(f"Section 5.2, identification {i + 1}: Nelder-Mead")
        found = nelder_mead.search(objective, LISTING_START, scale.thousands)
        tell(f"Section 5.2, identification {i + 1}: windows")
        # from the data's own start: at Listing 1's the spring is a thousand times too soft
        ours, fit, _ = windows.search([objective], BENCH.B1)
        out["identifications"].append(
            {
                "y_of_rest": objective.of_rest,
                "nelder_mead": _row(found, objective),
                "windows": {**_row(ours, objective), "chi2_dof": fit.chi2_dof},
            }
        )
    return out


def measured(scale: Scale) -> list[Objective]:
    """Two recordings of the rig at the same setting."""
    rig = VirtualRig(BENCH, EFFECTS, seed=scale.seed)
    ts = np.arange(round(scale.duration * RATE) + 1) / RATE
    rng = np.random.default_rng(scale.seed)
    out = []
    for _ in PAPER:
        phi = rig.run(ts, omega=OMEGA) + NOISE * rng.standard_normal((ts.size, 2))
        out.append(Objective(ts, phi[:, 0], phi[:, 1], OMEGA))
    return out


def _row(found: nelder_mead.Searched, objective: Objective) -> dict[str, Any]:
    m = motion(found.x, objective.omega, objective.ts)
    return {
        "x": dict(zip(ORDER, found.x.tolist(), strict=True)),
        "y": found.y,
        "rms_phi1": float(np.sqrt(np.mean((np.asarray(m.phi1) - objective.phi1) ** 2))),
        "rms_phi2": float(np.sqrt(np.mean((np.asarray(m.phi2) - objective.phi2) ** 2))),
        "evaluations": found.evaluations,
        "seconds": found.seconds,
        "message": found.message,
    }
