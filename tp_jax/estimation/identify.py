"""`identify`: the parameters of a campaign, from one or more starts, and which can be trusted."""

import dataclasses
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Literal

import numpy as np

from tp_jax._blas import one_blas_thread
from tp_jax._version import __version__
from tp_jax.errors import InputError
from tp_jax.estimation import methods
from tp_jax.estimation.checkpoint import Checkpoint
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.free_run_search import ITERATIONS
from tp_jax.estimation.free_run_trials import search_free_runs
from tp_jax.estimation.identification import (
    Identification,
    parameter_table,
    start_warnings,
    warnings,
)
from tp_jax.estimation.intervals import correlations
from tp_jax.estimation.multistart import Trial, search
from tp_jax.estimation.noise_levels import fitted_noise, with_noise
from tp_jax.estimation.optimistix_methods import Solver
from tp_jax.estimation.prepared_campaign import PreparedCampaign, prepare_campaign
from tp_jax.estimation.ridges import intervals_over_ridges
from tp_jax.estimation.robust import LOSSES, Loss
from tp_jax.estimation.schedule import Objective, Schedule
from tp_jax.estimation.starts import Sampling
from tp_jax.estimation.starts import starts as made_starts
from tp_jax.estimation.success import success
from tp_jax.model.plausible import check_values
from tp_jax.recordings import Campaign
from tp_jax.results.identification import (
    VERSION,
    IdentifyProvenance,
    StartRecord,
    SuccessRecord,
)
from tp_jax.results.sizes import Correlation

REACHED = 1.0  # chi-square within which a start counts as having reached the best
NOISE_ROUNDS = 4
SETTLED = 0.01  # relative change of a noise level that is not worth another round

Progress = Callable[[str, float | None], None]


@one_blas_thread()
def identify(
    campaign: Campaign,
    *,
    model: str = "newton",
    method: str = "least-squares",
    solver: Solver | None = None,
    starts: int = 1,
    fix: Mapping[str, float] | None = None,
    bound: Mapping[str, tuple[float, float]] | None = None,
    seed: int = 0,
    progress: Progress | None = None,
    objective: Objective | None = None,
    loss: Loss = "linear",
    noise: Literal["data", "fit"] = "data",
    sampling: Sampling = "sobol",
    raw_starts: bool = False,
    iterations: int = ITERATIONS,
    checkpoint: str | Path | None = None,
    resume: bool = False,
) -> Identification:
    """Fits the baseline's parameters to the recordings that are not held out.

    Args:
        campaign: see `load_campaign`.
        model: "newton", or "paper" for the equations as printed.
        method: "least-squares" (Gauss-Newton with the windows' states projected out),
            "variable-projection" (the same by optimistix), "levenberg-marquardt", "dogleg",
            "gauss-newton" or "bfgs" (optimistix), or "nelder-mead".
        solver: any least-squares solver or minimiser of optimistix instead, `VariableProjection`
            among them; it minimises the windows' residuals in coordinates in which one standard
            error is one.
        starts: the first is the data's own, the others are drawn over the bounds (see `starts`).
        fix: parameters to hold, by name, SI units.
        bound: (lower, upper) by name, SI units.
        seed: of the starts.
        progress: called with a stage's name and the part of it that is done.
        objective: "windows" that grow, each with a state of its own, or "free-run": the windows
            are whole recordings; with nelder-mead (17) exactly, for which it is the only one.
        loss: of a residual: "linear" for least squares, or "huber", "soft-l1", "cauchy".
        noise: its level by channel from the "data", or estimated with the "fit".
        sampling: "sobol" or "latin-hypercube".
        raw_starts: start at the points as drawn, not where the weak form of the equations takes
            them (see `weak_form`).
        iterations: of nelder-mead.
        checkpoint: file in which finished starts are kept.
        resume: go on from that file.

    Raises:
        InputError: an unknown parameter or method, bounds in the wrong order, nothing to resume.
        Interrupted: by Ctrl-C; what is done is in the checkpoint.
    """
    begin = time.perf_counter()
    report = progress or (lambda stage, fraction: None)  # noqa: ARG005
    chosen = method if solver is None else solver
    aim = objective or methods.usual_objective(chosen)
    _check(fix or {}, bound or {}, campaign.B1, starts, loss, noise)
    methods.check(chosen, aim)
    setting = prepare_campaign(
        campaign, model=model, fix=dict(fix or {}), bound=dict(bound or {}), effects=()
    )
    kept = _checkpoint(
        checkpoint,
        resume,
        setting,
        {
            "method": methods.described(chosen),
            "objective": aim,
            "loss": loss,
            "seed": seed,
            "sampling": sampling,
            "raw starts": raw_starts,
            "iterations": iterations if chosen == methods.NELDER_MEAD else None,
            "number of starts": None if sampling == "sobol" else starts,
        },
    )
    report("a start from the data", None)
    begun = made_starts(setting, starts, seed=seed, sampling=sampling, raw=raw_starts)
    schedule = Schedule(setting, methods.fitter(chosen, setting, aim), objective=aim, loss=loss)
    if chosen == methods.NELDER_MEAD:
        trials = search_free_runs(
            begun, schedule, checkpoint=kept, progress=report, max_iterations=iterations
        )
    else:
        trials = search(begun, schedule, checkpoint=kept, progress=report)
    report("intervals", None)
    best = min(range(starts), key=lambda i: trials[i].end.cost)
    if not np.isfinite(trials[best].end.cost):
        raise InputError(
            "No start came to anything: the motion could not be integrated from any of them; "
            "loosen --fix and --bound, or try more starts."
        )
    fit = _rebuilt(schedule, trials[best])
    if noise == "fit":
        fit, setting = _with_fitted_noise(schedule, fit)
    entries = intervals_over_ridges(fit, setting, loss)
    lowest = trials[best].end.cost
    reached = [t.end.cost - lowest <= REACHED for t in trials]
    found = success(reached, [t.alone for t in trials])
    return Identification(
        schema=VERSION,
        campaign=campaign.name,
        model=model,
        method=methods.name_of(chosen),
        objective_kind=aim,
        sizes=parameter_table(entries, setting),
        correlation=Correlation.read(correlations(fit, setting)),
        objective=trials[best].end.objective,
        chi2_dof=fit.chi2_dof,
        noise_floor={**setting.noise},
        starts=tuple(StartRecord.read(t.record(i)) for i, t in enumerate(trials)),
        success=SuccessRecord.read(found.to_dict()),
        warnings=(*warnings(fit, setting, entries), *start_warnings(trials, reached)),
        provenance=IdentifyProvenance(
            version=__version__,
            seed=seed,
            data_sha256=campaign.data_sha256,
            eps=fit.values.get("eps2"),
            horizon_s=fit.problem.windows.horizon,
            loss=loss,
            noise=noise,
            sampling=sampling,
            raw_starts=raw_starts,
            wall_s=round(time.perf_counter() - begin, 2),
        ),
        fit=fit,
        trials=tuple(trials),
    )


def _rebuilt(schedule: Schedule, trial: Trial) -> Fit:
    """The fit an outcome is of, the same whether it was just found or read from a file."""
    values = trial.end.values(trial.start.values, schedule.setting.unknowns())
    fit = schedule.as_it_is(values, trial.end.states)
    fit.converged, fit.message = trial.end.converged, trial.end.message
    fit.evaluations = trial.alone
    return fit


def _with_fitted_noise(schedule: Schedule, fit: Fit) -> tuple[Fit, PreparedCampaign]:
    """Noise levels and parameters in turn, until the levels stay."""
    for _ in range(NOISE_ROUNDS):
        rise = fitted_noise(fit)
        setting = with_noise(schedule.setting, schedule.setting.levels * rise)
        schedule = schedule.of(setting)
        fit = schedule.refine(fit)
        if np.all(np.abs(rise - 1.0) < SETTLED):
            break
    return fit, schedule.setting


def _checkpoint(
    path: str | Path | None, resume: bool, setting: PreparedCampaign, settings: dict[str, Any]
) -> Checkpoint | None:
    if path is None:
        if resume:
            raise InputError("To resume, the file with the finished starts must be named.")
        return None
    campaign = setting.campaign
    known = {
        n: None if value is None else dataclasses.astuple(value)
        for n, value in (("B2", campaign.B2), ("k", campaign.k))
    }
    data = {
        "data": campaign.data_sha256,
        "known": known,
        "recordings": [
            [r.label, r.forced, r.omega, r.start, r.held_out, r.measured_drive]
            for r in setting.recordings
        ],
        "model": setting.model,
        "fixed parameters": setting.fixed,
        "bounds": setting.bounds,
        "version": __version__,
        "eps": setting.sharpest,
    }
    kept = Checkpoint(Path(path), data | settings)
    if resume:
        kept.resume()
    return kept


def _check(
    fix: Mapping, bound: Mapping, B1: float | None, starts: int, loss: str, noise: str
) -> None:
    check_values(fix, bound, B1)
    if starts < 1:
        raise InputError(f"There must be one start or more, but {starts} were asked for.")
    if loss not in LOSSES:
        raise InputError(f"There is no loss {loss!r}, choose one of: {', '.join(LOSSES)}.")
    if noise not in ("data", "fit"):
        raise InputError(f"Noise is taken from the data or the fit, but not from {noise!r}.")
    if noise == "fit" and loss != "linear":
        raise InputError(
            f"Under the loss {loss} the residuals do not tell the noise; take it from the data."
        )
