"""Random rigs fit for a trial, and how large an effect may plausibly be."""

from collections.abc import Sequence

import numpy as np

from tp_jax.rig import BENCH, RigParameters, VirtualRig
from tp_jax.rig.plan import SLIDES, plan_runs

SPREAD = 0.5  # of every number about the bench's
MOVES = 0.05  # rad: a column that swings so far has moved
FARTHEST = 3.0  # rad: beyond, no spring of this kind goes
PACE = 0.02  # s between looks
ATTEMPTS = 200

#: Beyond what the effect draws for itself by this factor, it is no longer plausible.
PLAUSIBLE = 1.5
#: Sizes that mean all of something, so that there can be no more of it.
MOST = {
    "bearing_asymmetry": 0.95,
    "bearing_load": 0.9,
    "bearing_position": 0.95,
    "bearing_presliding": 1.0,
    "bearing_warmup": 1.8,
    "contact_asymmetry": 0.95,
    "contact_position": 0.95,
    "contact_presliding": 1.0,
    "contact_vibration": 0.95,
    "contact_wear": 1.8,
    "drive_steps": 1.0,
    "sensor1_nonlinearity": 1.0,
    "sensor2_nonlinearity": 1.0,
}


def draw_rig(
    rng: np.random.Generator, runs: int, duration: float
) -> tuple[RigParameters, int, list[dict[str, float]]]:
    """A rig within ±50 % of the bench whose column moves and whose rider slides.

    Args:
        rng: chance. runs: recordings of a campaign. duration: of each [s].

    Returns:
        Its numbers; the seed of its campaign; the runs that a campaign with that seed makes.
    """
    for _ in range(ATTEMPTS):
        parameters = BENCH.scaled(rng, SPREAD)
        seed = int(rng.integers(2**31))
        plan = runs_of(parameters, runs, seed)
        if usable(parameters, plan, duration):
            return parameters, seed, plan
    raise RuntimeError(f"None of {ATTEMPTS} rigs moved as it should.")


def runs_of(parameters: RigParameters, runs: int, seed: int) -> list[dict[str, float]]:
    """The runs that `rig.make_campaign` makes with a seed."""
    return plan_runs(parameters, runs, np.random.default_rng([seed, 1]))


def usable(parameters: RigParameters, plan: Sequence[dict[str, float]], duration: float) -> bool:
    """True if every column moves, none too far, and riders slide in all driven runs but one."""
    rig = VirtualRig(parameters)
    slid = 0
    for run in plan:
        rig.start(omega=run.get("omega"), release=run.get("release"), duration=duration)
        ts = np.arange(PACE, duration, PACE)
        phi1, phi2 = np.array([rig.motion(t)[:2] for t in ts.tolist()]).T
        if not MOVES < np.abs(phi1).max() < FARTHEST:
            return False
        slid += "omega" in run and np.ptp(phi2) > SLIDES
    return slid >= max(sum("omega" in run for run in plan) - 1, 1)


def largest(id: str, sizes: Sequence[float]) -> float:
    """Returns the most by which sizes that an effect drew for itself may be multiplied."""
    norm = float(np.linalg.norm(sizes))
    return min(PLAUSIBLE, MOST[id] / norm) if id in MOST else PLAUSIBLE


def applies(id: str, with_B2: bool) -> bool:
    """True if an effect can be known from the recordings at all."""
    if id == "drive_delay":  # the drives of a trial are commanded, not recorded
        return False
    # no angle shows it unless both moments of inertia are given
    return with_B2 or id != "reaction_factor"
