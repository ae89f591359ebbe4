"""Plan of the runs of a campaign: some driven ones about resonance, and a decay."""

import itertools

import numpy as np

from tp_jax.rig.parameters import RigParameters
from tp_jax.rig.simulator import VirtualRig

LOWEST, HIGHEST = 0.4, 1.35  # of the frequency of the two bodies together
SLIDES = 0.03  # rad: a rider that moves so far has slid
WATCHED = 3.0  # s
ATTEMPTS = 6


def plan_runs(
    parameters: RigParameters, runs: int, rng: np.random.Generator
) -> list[dict[str, float]]:
    """A decay and `runs - 1` driven runs, the arguments of `VirtualRig.start` for each.

    Frequencies are spread over the resonance, one at random in each of as many parts of it. Where
    the rider would not slide they are moved towards the resonance; the slowest run may go without.
    """
    center = float(np.sqrt(parameters.k / (parameters.B1 + parameters.B2)))
    edges = np.linspace(LOWEST, HIGHEST, runs)
    # neighbours keep their distance
    drawn = [low + (high - low) * rng.uniform(0.2, 0.8) for low, high in itertools.pairwise(edges)]
    rig = VirtualRig(parameters)
    plan = [{"release": _release(parameters, rng)}]
    for i, part in enumerate(drawn):
        for _ in range(ATTEMPTS if i and parameters.has_rider else 0):
            if _slides(rig, center * part):
                break
            # never all the way, so that no two runs are alike
            part += 0.35 * (0.95 - part)
        plan.append({"omega": round(float(center * part), 2)})
    return plan


def _release(p: RigParameters, rng: np.random.Generator) -> float:
    """An angle from which the rider slides, if one within a radian and a bit is enough."""
    needed = (p.Ts1 * (p.B1 + p.B2) / p.B2 + p.M1) / p.k if p.has_rider else 0.0
    return min(max(float(rng.uniform(0.45, 0.75)), 1.5 * needed), 1.2)


def _slides(rig: VirtualRig, omega: float) -> bool:
    """True if the rider of a rig leaves its place in the first seconds of a driven run."""
    rig.start(omega=omega)
    return any(abs(rig.motion(t)[1]) > SLIDES for t in np.arange(0.1, WATCHED, 0.1).tolist())
