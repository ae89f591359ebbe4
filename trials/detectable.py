"""Size that an effect must have to be seen: measured on the virtual rig, without any model of it.

The sum of squares of what only the effect explains (`projection`), in units of the noise, is the
noncentrality of the best test for that effect; its minimum detectable size is where this is found
with power 0.95 at a family-wise false alarm of 0.05.

This is the scale by which sizes are drawn. Scores use the diagnosis' own minimum detectable size.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy import optimize, stats

from tp_jax.rig.effects import catalogue
from trials.effects.base import is_cousin
from trials.projection import Bench, noncentralities

POWER, FAMILY_WISE = 0.95, 0.05
TRIES = 4
AMID, NEAR = 3.0, 1.6  # times the detectable size that is to be tried, and within which factor
LARGEST = 1.5  # of the sizes that an effect draws for itself
UNSEEN = 0.01  # of the noncentrality that is needed
OWN = 0.1  # of the mean square of runs' amplitudes, for a run to say how it shows its own


def noncentrality(
    bench: Bench, id: str, sizes: Sequence[float], shapes: Mapping[str, float]
) -> float:
    """Sum of squares over all samples of what only the effect explains, in noise variances.

    Args:
        bench: the campaign. id: of the effect, with its sizes and shape constants as `VirtualRig`
            takes them.
    """
    return float(noncentralities(bench, id, sizes, shapes)[0].sum())


def least_noncentrality(
    bench: Bench, id: str, sizes: Sequence[float], shapes: Mapping[str, float]
) -> float:
    """The same for amplitudes as large as these together, in their least detectable direction.

    Of two amplitudes, from three directions of both. Where every run has amplitudes of its own,
    all of them in the run that shows them least, though at all.
    """
    effect = catalogue()[id]
    if effect.per_run:
        found, squares = noncentralities(bench, id, sizes, shapes)
        # a run that by chance has next to nothing of it shows what the others have
        own = squares > max(OWN * squares.mean(), 0.0)
        per_unit = found[own] / squares[own]
        shown = per_unit[per_unit > UNSEEN * per_unit.max(initial=0.0)]
        return float(shown.min(initial=np.inf) * squares.sum()) if shown.size else 0.0
    if len(effect.amplitudes) == 1:
        return noncentrality(bench, id, sizes, shapes)
    size, angles = float(np.linalg.norm(sizes)), np.pi / 3.0 * np.arange(3)
    at = [
        noncentrality(bench, id, (size * float(np.cos(x)), size * float(np.sin(x))), shapes)
        for x in angles
    ]
    # cos^2 V11 + 2 cos sin V12 + sin^2 V22
    terms = np.stack([np.cos(angles) ** 2, np.sin(2.0 * angles), np.sin(angles) ** 2], axis=1)
    one, both, two = np.linalg.solve(terms, at)
    return max(float(np.linalg.eigvalsh([[one, both], [both, two]])[0]), 0.0)


def needed(bench: Bench, id: str) -> float:
    """Noncentrality at which an effect is found with the power.

    One of the catalogue by a test of its amplitudes, one of many such tests. One from outside it
    by a test that looks for nothing in particular, of the sum of squares of all samples; where
    `bench` says so, one akin to an effect of the catalogue as if it were that.
    """
    effect = catalogue()[id]
    if effect.in_catalogue or (bench.cousins_by_kind and is_cousin(effect)):
        dof = len(effect.amplitudes) * (bench.runs if effect.per_run else 1)
        tests = sum(each.in_catalogue for each in catalogue().values())
    else:
        dof, tests = bench.samples, 1
    critical = stats.chi2.isf(FAMILY_WISE / tests, dof)
    found = optimize.root_scalar(
        lambda x: stats.ncx2.sf(critical, dof, x) - POWER, bracket=(1e-3, 1e6), method="brentq"
    )
    return float(found.root)


def minimum_detectable(
    bench: Bench, id: str, sizes: Sequence[float], shapes: Mapping[str, float]
) -> float:
    """Finds the factor that makes these sizes just detectable; inf: never.

    As in diagnosis.json: so large that it is found in its least detectable direction. Measured at
    about three times the answer, amid the sizes that are to be drawn, and taken from there in
    proportion.
    """
    wanted = needed(bench, id)
    factor, shown = 0.3, 0.0  # tried next; the last at which anything was to be seen
    answer = float("inf")
    for _ in range(TRIES):
        found = least_noncentrality(bench, id, tuple(factor * x for x in sizes), shapes)
        if found < UNSEEN * wanted:
            if not shown and factor >= 1.0:
                break
            # too small a step for a law with a threshold, or too small a size to begin with
            factor = float(np.sqrt(factor * shown)) if shown else 1.0
            continue
        answer, shown = factor * float(np.sqrt(wanted / found)), factor
        factor = min(AMID * answer, LARGEST)
        if abs(np.log(factor / shown)) < np.log(NEAR):
            break
    return answer
