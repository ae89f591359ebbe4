"""One rig of the study: simulated by `tp_jax.rig`, which knows nothing of the model, and fitted."""

import dataclasses
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from scripts._coverage.settings import Settings

PROFILED = ("Tst", "T0")
"""Parameters whose interval is that of their likelihood profile."""


def study(number: int, settings: Settings) -> dict[str, Any]:
    """Truth and intervals of one rig.

    Args:
        number: of the rig; with the settings' seed it decides everything random.
        settings: of the study.
    """
    from tp_jax.estimation.intervals import intervals
    from tp_jax.estimation.prepared_campaign import prepare_campaign
    from tp_jax.estimation.schedule import fit_over_schedule
    from tp_jax.estimation.sharpen import fit_with_sharp_friction
    from tp_jax.estimation.start import initial_values
    from tp_jax.identifiability.profile_likelihood import profiles
    from tp_jax.recordings import load_campaign
    from tp_jax.rig import make_campaign
    from trials.draw import draw_rig

    begin = time.perf_counter()
    rng = np.random.default_rng([settings.seed, number])
    parameters, seed, _ = draw_rig(rng, settings.runs, settings.duration)
    with tempfile.TemporaryDirectory() as folder:
        make_campaign(
            Path(folder, "rig"),
            parameters,
            runs=settings.runs,
            rate=settings.rate,
            duration=settings.duration,
            noise=settings.noise,
            bits=settings.bits,
            seed=seed,
        )
        campaign = load_campaign(Path(folder, "rig"))
    simulated = time.perf_counter()
    setting = prepare_campaign(campaign, effects=())
    fit = fit_with_sharp_friction(
        setting, fit_over_schedule(setting, initial_values(setting), setting.unknowns())
    )
    found = intervals(fit, setting)
    by_profile = {p.name: p for p in profiles(fit, setting, PROFILED)}
    truth = dataclasses.asdict(parameters)
    rows = {}
    for name, entry in found.items():
        if name in truth:
            rows[name] = _row(truth[name], entry["value"], entry["ci95"])
    for name, p in by_profile.items():
        rows[name]["wald"] = {k: rows[name][k] for k in ("value", "ci95", "covered")}
        rows[name] |= _row(truth[name], p.best, p.ci95)
    return {
        "rig": number,
        "chi2_dof": fit.chi2_dof,
        "converged": fit.converged,
        "parameters": rows,
        "seconds": {
            "simulation": simulated - begin,
            "estimation": time.perf_counter() - simulated,
        },
    }


def _row(truth: float, value: float, ci95) -> dict[str, Any]:
    """An open end holds whatever lies beyond."""
    low, high = ci95
    held = (low is None or low <= truth) and (high is None or truth <= high)
    return {
        "truth": truth,
        "value": value,
        "ci95": [low, high],
        "covered": bool(held),
        "open": low is None or high is None,
    }
