"""Checks whether what a diagnosis adds makes the model predict runs worse that were never given.

A model does harm where after^2 > before^2 by more than 2 % of before^2 and one standard error of
the difference together, both on the sealed runs. *Windowed*: mean squares as `gap.held_out` has
them, standard error from the scatter of windows. *Free run*: from the state at a run's start,
estimated on its first moments, never corrected after, with a zero or size of the run's own as its
windows have it; mean squares over channels and runs, standard error from the scatter of runs (none
from a single one). A model that cannot be integrated where the one before it could does harm.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tp_jax.effects import catalogue, get, laws
from tp_jax.estimation.layout import Values
from tp_jax.estimation.prepared_campaign import PreparedCampaign, prepare_campaign
from tp_jax.gap.free_run import free_runs, start_state
from tp_jax.gap.held_out import HeldOut, evaluate
from trials.kept import kept
from trials.schema import HARM
from trials.seal import diagnosis_file
from trials.sealed_runs import SHORTEST, numbers, together

TOLERATED = 0.02  # of before^2: less is no harm that anybody would notice
NOTHING: dict[str, bool | None] = {"windowed": None, "free_run": None}


def asked(diagnosis: Mapping[str, Any]) -> bool:
    """True if a diagnosis adds anything to the model: its causes, with a fit of them."""
    after = (diagnosis.get("fits") or {}).get("after")
    return bool(diagnosis.get("causes")) and after is not None


def measured_harm(
    root: Path, entry: Mapping[str, Any], diagnosis: Mapping[str, Any]
) -> dict[str, Any]:
    """Harm of a diagnosis, windowed and in free run; None where it adds nothing.

    Also None where its model has parts that are not in the catalogue. Kept beside the diagnosis,
    and read from there the next time.
    """
    known = {*catalogue(), *laws()}
    if not asked(diagnosis) or not set(diagnosis["fits"]["after"]["effects"]) <= known:
        return dict(NOTHING)
    case = entry["case"]
    return kept(
        kept_file(root, case),
        diagnosis_file(root, case),
        HARM,
        lambda: _measure(root, entry, diagnosis),
    )


def kept_file(root: Path, case: str) -> Path:
    """Names the file in which the answer is kept."""
    return diagnosis_file(root, case).with_name("harm.json")


def worse(before: np.ndarray, after: np.ndarray, weights: np.ndarray) -> bool | None:
    """True if errors grow beyond what is tolerated and beyond chance.

    Args:
        before, after: (n,) mean squares of each window or run [rad^2].
        weights: (n,) of each in the mean; all alike: ones.

    Returns:
        None where nothing could be compared, for even `before` is not finite anywhere.
    """
    known = np.isfinite(before) & (weights > 0.0)
    if not known.any():
        return None
    before, after, weights = before[known], after[known], weights[known] / weights[known].sum()
    if not np.isfinite(after).all():
        return True
    mean, change = float(weights @ before), float(weights @ (after - before))
    error = 0.0
    if before.size > 1:
        spread = weights * (after - before - change)
        error = float(np.sqrt(spread @ spread * before.size / (before.size - 1)))
    return change > TOLERATED * mean + error


def _measure(root: Path, entry: Mapping[str, Any], diagnosis: Mapping[str, Any]) -> dict[str, Any]:
    held_out = diagnosis["gap"].get("held_out") or []
    setting = prepare_campaign(together(root, entry["case"], held_out), model=diagnosis["model"])
    horizon = float(diagnosis["gap"].get("horizon_s") or SHORTEST)
    records = [diagnosis["fits"][model] for model in ("before", "after")]
    effects = [[], [get(id) for id in records[1]["effects"]]]
    values = [numbers(setting, record) for record in records]
    held = [evaluate(setting, v, horizon, e) for v, e in zip(values, effects, strict=True)]
    free = [_free_squares(each.setting or setting, each.fit.values, horizon) for each in held]
    (one, weights), (two, _) = (_by_window(each) for each in held)
    # a channel has its mean over all windows, and the mean over channels is what counts
    return {
        "windowed": worse(one, two, weights),
        "free_run": worse(free[0], free[1], np.ones(len(free[0]))),
        "rms": {
            "windowed": [_root(each.mean_square()) for each in held],
            "free_run": [_root(float(each.mean())) for each in free],
        },
    }


def _by_window(held: HeldOut) -> tuple[np.ndarray, np.ndarray]:
    """Mean squares (w,) by window, so weighted (w,) that their mean is `held.mean_square()`.

    NaN, weighted as the others are on average, where the model could not be integrated.
    """
    used = held.samples.sum(axis=0) > 0
    total = np.maximum(held.samples.sum(axis=0), 1.0)
    share = (held.samples / total)[:, used].mean(axis=1)
    part = (held.squares / total)[:, used].mean(axis=1)
    lost = share <= 0.0
    share = np.where(lost, 1.0 / share.size, share)
    return np.where(lost, np.nan, part / share), share


def _free_squares(setting: PreparedCampaign, values: Values, horizon: float) -> np.ndarray:
    """Mean squares (r,) over the channels of the sealed runs [rad^2]; NaN: not integrated."""
    which = list(setting.held_out)
    states = np.array([start_state(setting, values, i, horizon) for i in which])
    runs = free_runs(setting, values, which, states)
    out = []
    for i, y in zip(which, runs, strict=True):
        p = setting.prepared[i]
        out.append(float((((y - p.y)[:, p.channels]) ** 2).mean(axis=0).mean()))
    return np.array(out)


def _root(square: float) -> float | None:
    return float(np.sqrt(square)) if np.isfinite(square) else None
