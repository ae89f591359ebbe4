"""Starts of a multi-start search: points spread over the bounds of the unknowns.

A point as drawn is far away: bounds span up to seven powers of ten. Most of its numbers need no
start at all, because the weak form of the equations is linear in them (`weak_form`). So unless
asked not to, a start keeps of its point the one number that is not, T0, and takes the others from
the equations over a bootstrap sample of the data, another one for each start.

Source: Wood (2001), Biometrics 57:240 (bootstrap restarting).
"""

import dataclasses
from typing import Literal, get_args

import numpy as np
from scipy.stats import qmc

from tp_jax.errors import InputError
from tp_jax.estimation.layout import Unknown, Values
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.estimation.weak_form import WeakForm
from tp_jax.model.parameters import Parameter

Sampling = Literal["sobol", "latin-hypercube"]
SAMPLINGS: tuple[str, ...] = get_args(Sampling)

NEAR = 10.0  # typical sizes to which an unknown that may be anything is drawn


@dataclasses.dataclass(frozen=True)
class Axis:
    """Axis along which one unknown is drawn: uniformly between two ends of a coordinate.

    The coordinate is the logarithm; for what may be zero asinh(value / typical), which is linear
    up to the typical size and logarithmic beyond; and the value itself for what has either sign.
    """

    name: str
    lower: float
    upper: float
    kind: Literal["log", "asinh", "value"]
    typical: float

    @classmethod
    def of(cls, spec: Parameter, bounds: tuple[float, float] | None) -> "Axis":
        """Makes the axis of a parameter, scaled to the rig; bounds of the user replace its own."""
        low, high = bounds or (spec.lower, spec.upper)
        if spec.transform == "log" or spec.lower > 0.0:
            # a bound of zero says nothing, and has no logarithm
            return cls(spec.name, low or min(spec.lower, high), high, "log", spec.typical)
        if low >= 0.0:
            return cls(spec.name, low, high, "asinh", spec.typical)
        if bounds is None:
            low, high = max(low, -NEAR * spec.typical), min(high, NEAR * spec.typical)
        if spec.name == "phase" and bounds is None:
            low, high = -np.pi, np.pi
        return cls(spec.name, low, high, "value", spec.typical)

    def at(self, share: np.ndarray | float) -> np.ndarray:
        """Values at parts, from 0 to 1, of the way from the lower to the upper end."""
        to, back = {
            "log": (np.log, np.exp),
            "asinh": (
                lambda v: np.arcsinh(v / self.typical),
                lambda c: self.typical * np.sinh(c),
            ),
            "value": (lambda v: v, lambda c: c),
        }[self.kind]
        low, high = to(self.lower), to(self.upper)
        return np.clip(back(low + np.asarray(share) * (high - low)), self.lower, self.upper)


@dataclasses.dataclass(frozen=True)
class Start:
    """Start of a search: all numbers, and the drawn point (u,); None for the data's own."""

    values: Values
    point: np.ndarray | None


def axes(setting: PreparedCampaign) -> list[Axis]:
    """One for each unknown of the baseline."""
    problem = setting.layout
    specs = [
        problem.parameters[problem.index[u.name]].scaled(setting.fixed["B1"])
        for u in setting.unknowns()
    ]
    return [Axis.of(s, setting.bounds.get(s.name)) for s in specs]


def points(
    setting: PreparedCampaign, n: int, seed: int, sampling: Sampling = "sobol"
) -> np.ndarray:
    """Draws n points (n, u) over the bounds, in SI units.

    Of Sobol's sequence the first ones stay the same when more are asked for.
    """
    along = axes(setting)
    if sampling not in SAMPLINGS:
        raise InputError(f"There is no sampling {sampling!r}, choose {' or '.join(SAMPLINGS)}.")
    if n == 0:
        return np.zeros((0, len(along)))
    if sampling == "sobol":
        share = qmc.Sobol(len(along), rng=seed).random_base2((n - 1).bit_length())[:n]
    else:
        share = qmc.LatinHypercube(len(along), rng=seed).random(n)
    return np.stack([a.at(share[:, j]) for j, a in enumerate(along)], axis=1)


def starts(
    setting: PreparedCampaign,
    n: int,
    *,
    seed: int = 0,
    sampling: Sampling = "sobol",
    raw: bool = False,
) -> list[Start]:
    """The data's own start and n - 1 drawn ones.

    Args:
        setting: the campaign.
        n: how many.
        seed: of the points and of the bootstrap samples.
        sampling: of the points.
        raw: start at the points themselves rather than where the weak form takes them.
    """
    unknowns = setting.unknowns()
    weak = WeakForm(setting)
    found = [Start(_inside(setting, unknowns, weak.start()), None)]
    for i, x in enumerate(points(setting, n - 1, seed, sampling)):
        values = weak.base.put(unknowns, x)
        if not raw:
            T0 = values.get("T0") if Unknown("T0") in unknowns else None
            values = weak.start(T0=T0, rng=np.random.default_rng([seed, i]))
        found.append(Start(_inside(setting, unknowns, values), x))
    return found


def _inside(setting: PreparedCampaign, unknowns: tuple[Unknown, ...], values: Values) -> Values:
    """Within the user's bounds."""
    along = axes(setting)
    x = [np.clip(v, a.lower, a.upper) for v, a in zip(values.pick(unknowns), along, strict=True)]
    limited = [u.name in setting.bounds for u in unknowns]
    return values.put(unknowns, np.where(limited, x, values.pick(unknowns)))
