"""Draws of fitted parameters for ArviZ, which summarises, compares and plots them.

A fit gives values, 95 % intervals and the correlations of their errors; drawn from are normal
distributions of just these, of the logarithm where an interval is symmetric in that, and with two
halves of different width where it is in neither. It is the
normal approximation of the posterior at its peak, not a run of a sampler: what holds far from the
peak (a friction that may be zero, a ridge) is as good as the intervals are.
"""

from collections.abc import Mapping
from contextlib import suppress
from importlib import import_module
from typing import Any, Protocol, runtime_checkable

import numpy as np

from tp_jax._version import __version__
from tp_jax.errors import InputError
from tp_jax.model.parameters import BY_NAME, Parameter

TO_LIMIT = 1.959964
"""Standard deviations from a normal distribution's middle to the end of its 95 % interval."""

SYMMETRIC = 1e-3
"""Relative difference of an interval's two halves that counts as none."""


@runtime_checkable
class Found(Protocol):
    """Result of `identify` or of `diagnose`."""

    def to_dict(self) -> dict[str, Any]:
        """The result as plain numbers."""
        ...


def to_arviz(
    found: Found | Mapping[str, Any], *, draws: int = 1000, chains: int = 4, seed: int = 0
) -> Any:
    """Draws of the fitted parameters, as ArviZ takes them.

    Args:
        found: what `identify` or `diagnose` returned, or its dict, as read from a JSON file.
        draws: of each chain. chains: so many; draws are independent, within them and between.
        seed: same seed, same draws.

    Returns:
        A DataTree (ArviZ 1) or an InferenceData (ArviZ 0). `posterior` has the parameters that the
        data determine, SI units in their attributes; `constant_data` has the values of the others,
        fixed ones and those at a bound.

    Raises:
        InputError: ArviZ is not installed, no draws are asked for, or no parameter has an interval.

    Example:
        >>> from tp_jax.report import to_arviz
        >>> k = {"value": 0.45, "unit": "N m/rad", "ci95": [0.44, 0.46], "identifiable": True}
        >>> to_arviz({"parameters": {"k": k}}).posterior["k"].shape  # doctest: +SKIP
        (4, 1000)
    """
    arviz = _arviz()
    if draws < 1 or chains < 1:
        raise InputError(
            f"There must be one draw and one chain or more, but {draws} draws of {chains} chains "
            "were asked for."
        )
    result = found if isinstance(found, Mapping) else found.to_dict()
    parameters = result.get("parameters") or {}
    known = {name: p for name, p in parameters.items() if _is_determined(p)}
    if not known:
        raise InputError("No parameter of this result has an interval, so nothing can be drawn.")
    z = _normal(list(known), result.get("correlation"), chains * draws, seed)
    B1 = (parameters.get("B1") or {}).get("value") or 1.0
    posterior = {}
    for i, (name, p) in enumerate(known.items()):
        low, high = p["ci95"]
        drawn = _drawn(p["value"], low, high, z[:, i], BY_NAME.get(name), B1)
        posterior[name] = drawn.reshape(chains, draws)
    constant = {
        name: np.array(float(p["value"]))
        for name, p in parameters.items()
        if name not in known and p.get("value") is not None
    }
    groups = {"posterior": posterior} | ({"constant_data": constant} if constant else {})
    if int(arviz.__version__.split(".")[0]) >= 1 or arviz.__name__ == "arviz_base":
        tree = arviz.from_dict(groups)
    else:
        tree = arviz.from_dict(**groups)
    for name, p in parameters.items():
        for group in groups:
            if name in groups[group]:
                tree[group][name].attrs["units"] = str(p.get("unit", ""))
    tree["posterior"].attrs.update(
        inference_library="tp_jax",
        inference_library_version=__version__,
        sampling="normal approximation from intervals and correlations, no sampler",
        campaign=str(result.get("campaign", "")),
        model=str(result.get("model", "")),
    )
    return tree


def _arviz() -> Any:
    for name in ("arviz", "arviz_base"):
        with suppress(ImportError):
            return import_module(name)
    raise InputError(
        "The export needs ArviZ, which is not installed: pip install arviz (or arviz-base, without "
        "its plots)."
    )


def _is_determined(p: Mapping[str, Any]) -> bool:
    """True where the data give a parameter an interval with two ends."""
    interval = p.get("ci95")
    ends = isinstance(interval, list | tuple) and len(interval) == 2 and None not in interval
    return ends and p.get("identifiable") is not False and p.get("value") is not None


def _normal(names: list[str], correlation: Any, n: int, seed: int) -> np.ndarray:
    """(n, q) standard normal draws, correlated as the errors of the parameters named."""
    matrix = np.eye(len(names))
    if isinstance(correlation, Mapping):
        told, full = list(correlation["names"]), np.array(correlation["matrix"], dtype=float)
        mine = [(i, told.index(name)) for i, name in enumerate(names) if name in told]
        at, of = ([pair[k] for pair in mine] for k in (0, 1))
        matrix[np.ix_(at, at)] = full[np.ix_(of, of)]
    value, vector = np.linalg.eigh(matrix)
    root = vector * np.sqrt(np.maximum(value, 0.0))  # of rounding, a little below zero
    return np.random.default_rng(seed).standard_normal((n, len(names))) @ root.T


def _drawn(
    value: float, low: float, high: float, z: np.ndarray, of: Parameter | None, B1: float
) -> np.ndarray:
    """Draws (n,) of a number with this 95 % interval, from standard normal ones.

    An interval that ends at a bound of its parameter, or at zero, is cut short there: the half has
    the other's width, and no draw is beyond the bound.
    """
    down, up = value - low, high - value
    if abs(up - down) <= SYMMETRIC * max(up, down):
        return value + (high - low) / (2.0 * TO_LIMIT) * z
    if low > 0.0:
        ratio_down, ratio_up = np.log(value / low), np.log(high / value)
        if abs(ratio_up - ratio_down) <= SYMMETRIC * max(ratio_up, ratio_down):
            return value * np.exp((ratio_down + ratio_up) / (2.0 * TO_LIMIT) * z)
    bounds = (0.0, 0.0) if of is None else (of.scaled(B1).lower, of.scaled(B1).upper)
    cut_low, cut_high = (
        end == 0.0 or abs(end - bound) <= SYMMETRIC * abs(bound)
        for end, bound in zip((low, high), bounds, strict=True)
    )
    in_logarithms = of is not None and of.transform == "log"
    if in_logarithms:
        down, up = np.log(value / low), np.log(high / value)
    if cut_low and not cut_high:
        down = up
    if cut_high and not cut_low:
        up = down
    moved = np.where(z < 0.0, down, up) / TO_LIMIT * z
    drawn = value * np.exp(moved) if in_logarithms else value + moved
    return np.clip(drawn, low if cut_low else None, high if cut_high else None)
