"""`sensitivity`: which parameters of a campaign matter, when, and which can be known at all."""

import dataclasses
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from tp_jax._blas import one_blas_thread
from tp_jax._version import __version__
from tp_jax.errors import InputError
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.intervals import intervals
from tp_jax.estimation.prepared_campaign import PreparedCampaign, prepare_campaign
from tp_jax.estimation.schedule import fit_over_schedule
from tp_jax.estimation.sharpen import fit_with_sharp_friction
from tp_jax.estimation.start import initial_values
from tp_jax.identifiability.design import UNKNOWNS, Design, designs_of
from tp_jax.identifiability.information import information
from tp_jax.identifiability.null_directions import Direction
from tp_jax.identifiability.profile_likelihood import Profile, profiles
from tp_jax.identifiability.rank import POINTS, rank
from tp_jax.model.parameters import BY_NAME
from tp_jax.model.plausible import MOST_SPREAD, check_names, check_values
from tp_jax.recordings import Campaign
from tp_jax.report.sensitivity import write_figures
from tp_jax.results.identification import Warned
from tp_jax.results.sensitivity import (
    VERSION,
    EstimateCorrelation,
    FitQuality,
    KnownParameter,
    SensitivityProvenance,
    SensitivityRecord,
)
from tp_jax.sensitivity_analysis import record
from tp_jax.sensitivity_analysis.local import Local, local
from tp_jax.sensitivity_analysis.measured_drives import about_the_mean
from tp_jax.sensitivity_analysis.morris import TRAJECTORIES, morris
from tp_jax.sensitivity_analysis.ranges import SPREAD, ranges
from tp_jax.sensitivity_analysis.sobol import SAMPLES, sobol
from tp_jax.sensitivity_analysis.summary import summary

Progress = Callable[[str, float | None], None]


@dataclasses.dataclass(frozen=True, kw_only=True)
class SensitivityAnalysis(SensitivityRecord):
    """Result of `sensitivity`; `to_dict` gives it as plain numbers, schema tp-jax/sensitivity/1.

    fit: the point at which it was taken. profiles: likelihood profiles, of the parameters for
    which they were asked for. Neither is in `to_dict`.
    """

    fit: Fit = dataclasses.field(compare=False, metadata={"key": None})
    profiles: tuple[Profile, ...] = dataclasses.field(
        default=(), compare=False, metadata={"key": None}
    )

    def __repr__(self) -> str:
        rank = f"rank {self.structural.rank} of {self.structural.of}"
        unknown = [name for name, told in self.identifiable.items() if not told]
        not_told = f", not told: {', '.join(unknown)}" if unknown else ""
        return f"SensitivityAnalysis({self.campaign!r}: {rank}{not_told})"

    def summary(self) -> str:
        """A table for a terminal."""
        return summary(self)

    def write_figures(self, folder: str | Path) -> list[Path]:
        """Draws all figures as PNG; see `tp_jax.report.sensitivity.write_figures`."""
        return write_figures(self, folder)


@one_blas_thread()
def sensitivity(
    campaign: Campaign,
    *,
    model: str = "newton",
    fix: Mapping[str, float] | None = None,
    spread: float = SPREAD,
    samples: int = SAMPLES,
    trajectories: int = TRAJECTORIES,
    points: int = POINTS,
    profile: Sequence[str] = (),
    seed: int = 0,
    progress: Progress | None = None,
) -> SensitivityAnalysis:
    """Identifiability, local and global sensitivity of the parameters of a campaign.

    The campaign is fitted; structural identifiability is looked for at random points around the
    fit, everything else is taken at it, over the experiments that the fitted recordings are.

    Args:
        campaign: see `load_campaign`.
        model: "newton", or "paper" for the equations as printed.
        fix: parameters to hold, by name, SI units.
        spread: for the global indices, parameters run from the fit's value by this factor down to
            one by it up.
        samples: points of the Sobol' sequence, a power of two.
        trajectories: of the elementary effects.
        points: random points of the structural analysis.
        profile: parameters whose likelihood profile is wanted; all of them: ("all",).
        seed: of everything random.
        progress: called with a stage's name and the part of it that is done.

    Raises:
        InputError: an argument is not one that can be used.
    """
    begin = time.perf_counter()
    report = progress or (lambda stage, fraction: None)  # noqa: ARG005
    _check(fix or {}, campaign.B1, profile, spread, samples, trajectories, points)
    setting = prepare_campaign(campaign, model=model, fix=dict(fix or {}), effects=())
    wanted = _wanted(setting, profile)
    fit = fit_with_sharp_friction(
        setting,
        fit_over_schedule(setting, initial_values(setting), setting.unknowns(), progress=report),
    )
    if not np.isfinite(fit.cost):
        raise InputError(f"{campaign.name} could not be fitted: {fit.message}")
    found = profiles(fit, setting, wanted, progress=report) if wanted else ()
    designs = [about_the_mean(d, fit.values.get("gain")) for d in designs_of(setting, fit)]
    names = _names(designs, setting)
    values = {n: fit.values.get(n) for n in (*names, "reaction")}
    scale = {n: _size(n, values, setting) for n in names}
    given = _given(setting, fix or {})
    structure = rank(
        designs,
        {**scale, "reaction": values["reaction"]},
        names,
        points=points,
        seed=seed,
        progress=report,
    )
    structural = [_removed(d, given) for d in structure.directions]
    known = information(fit, setting)

    varied = [n for n in names if n not in given]
    if not varied:
        raise InputError(f"All parameters of {campaign.name} are held; let one of them free.")
    over = ranges(values, varied, setting.fixed["B1"], spread)
    through_time, variances, effects = [], [], []
    for i, d in enumerate(designs):
        report("sensitivity of the recordings", i / len(designs))
        through_time.append(local(d, values, names, scale))
        variances.append(sobol(d, values, over, samples=samples, seed=seed))
        effects.append(morris(d, values, over, trajectories=trajectories, seed=seed))
    parameters = _parameters(fit, setting, names, structural, given)
    directions = (*structural, *known.directions)
    matrix = tuple(tuple(row) for row in known.correlation.tolist())
    return SensitivityAnalysis(
        schema=VERSION,
        campaign=campaign.name,
        model=model,
        identifiable={n: p.identifiable for n, p in parameters.items()},
        parameters=parameters,
        null_directions=tuple(record.null_direction(d) for d in directions),
        structural=record.structural_rank(structure),
        correlation=EstimateCorrelation(names=tuple(known.names), matrix=matrix),
        local=record.local_sensitivity(through_time, scale),
        sobol=record.sobol_indices(variances, over, samples),
        morris=record.morris_effects(effects, over, trajectories),
        profile={p.name: record.profile_record(p) for p in found},
        quality=FitQuality(
            chi2_dof=fit.chi2_dof,
            converged=fit.converged,
            message=fit.message,
            noise_floor=dict(setting.noise),
        ),
        warnings=tuple(_warnings(fit, structural, through_time)),
        provenance=SensitivityProvenance(
            version=__version__,
            seed=seed,
            data_sha256=campaign.data_sha256,
            eps=fit.values.get("eps2"),
            horizon_s=fit.problem.windows.horizon,
            spread=spread,
            wall_s=round(time.perf_counter() - begin, 2),
        ),
        fit=fit,
        profiles=found,
    )


def _check(
    fix: Mapping[str, float],
    B1: float | None,
    profile: Sequence[str],
    spread: float,
    samples: int,
    trajectories: int,
    points: int,
) -> None:
    check_values(fix, None, B1)
    check_names([name for name in profile if name != "all"])
    for name in profile:
        if name in fix:
            raise InputError(f"Parameter {name} is fixed, so that it has no likelihood profile.")
    if not 1.0 < spread <= MOST_SPREAD:
        raise InputError(
            f"The spread must be a factor above 1 and at most {MOST_SPREAD:g}, but is {spread:g}."
        )
    if samples < 2 or samples & (samples - 1):
        raise InputError(f"The samples must be a power of two, but are {samples}.")
    if trajectories < 2:
        raise InputError(f"There must be two trajectories or more, but are {trajectories}.")
    if points < 1:
        raise InputError(f"There must be one point or more, but there are {points}.")


def _wanted(setting: PreparedCampaign, profile: Sequence[str]) -> list[str]:
    """Names of the parameters whose profile is asked for; refuses those that are not fitted."""
    there = [u.name for u in setting.unknowns() if u.name in UNKNOWNS]
    for n in profile:
        if n not in (*there, "all"):
            raise InputError(f"{n} is not fitted here, choose one of: {', '.join(there)}.")
    return there if "all" in profile else list(dict.fromkeys(profile))


def _names(designs: Sequence[Design], setting: PreparedCampaign) -> tuple[str, ...]:
    """Returns the names that any of the experiments may depend on, in the order of Listing 1.

    The amplitude of a sine is none of them where no recording has one.
    """
    there = {n for d in designs for n in d.unknowns}
    if not setting.sine and "A" not in setting.fixed:
        there.discard("A")
    return tuple(n for n in (*UNKNOWNS, "gain") if n in there)


def _size(name: str, values: Mapping[str, float], setting: PreparedCampaign) -> float:
    """The value, or what is typical where it is zero: there is no relative change of nothing."""
    typical = BY_NAME[name].scaled(setting.fixed["B1"]).typical
    if name == "Ts2":
        return max(values["Ts2"], values["Ts1"], values["Tst"], typical)
    value = abs(values[name])
    return value if value > 1e-3 * typical or BY_NAME[name].transform == "log" else typical


def _given(setting: PreparedCampaign, fix: Mapping[str, float]) -> dict[str, str]:
    """Says what is held, and why; B1 = 1 for want of a better number is not given."""
    given = {n: f"{n} is given" for n in setting.fixed}
    if setting.campaign.B1 is None and "B1" not in fix:
        del given["B1"]
    return given


def _removed(direction: Direction, given: Mapping[str, str]) -> Direction:
    reasons = [given[n] for n in direction.coefficients if n in given]
    return dataclasses.replace(direction, removed_by=reasons[0] if reasons else None)


def _parameters(
    fit: Fit,
    setting: PreparedCampaign,
    names: Sequence[str],
    structural: Sequence[Direction],
    given: Mapping[str, str],
) -> dict[str, KnownParameter]:
    found = intervals(fit, setting)
    free = {n for d in structural if d.removed_by is None for n in d.coefficients}
    # Without B1 the scale is free: it is B1's lack, the others are known relative to it.
    free = {n for n in free if n == "B1"} if "B1" in free else free
    free |= {n for d in structural if len(d.coefficients) == 1 for n in d.coefficients}
    out = {}
    for n in names:
        entry = found.get(n)
        held = n in given
        practical = held or (entry is not None and bool(entry["identifiable"]))
        out[n] = KnownParameter(
            value=fit.values.get(n),
            unit=BY_NAME[n].unit,
            ci95=None if entry is None else tuple(entry["ci95"]),
            standard_error=None if entry is None else entry["standard_error"],
            given=held,
            structural=n not in free,
            practical=practical,
            identifiable=n not in free and practical,
        )
    return out


def _warnings(fit: Fit, structural: Sequence[Direction], runs: Sequence[Local]) -> list[Warned]:
    out = []
    for d in structural:
        if d.removed_by is None:
            code = "unidentifiable" if len(d.coefficients) == 1 else "free_scale"
            text = f"No recording of these angles tells {d.text}."
            out.append(Warned(code=code, parameters=tuple(d.coefficients), text=text))
    if fit.chi2_dof > 1.2:
        text = (
            f"The misfit is {fit.chi2_dof**0.5:.3g} times the noise: what is said here holds for "
            "the model, not yet for the rig; run `tp-jax diagnose`."
        )
        out.append(Warned(code="misfit", parameters=(), text=text))
    if not fit.converged:
        out.append(Warned(code="not_converged", parameters=(), text=fit.message))
    doubtful = [r.label for r in runs if not r.reliable.all()]
    if doubtful:
        text = (
            f"Derivatives along the whole of {', '.join(doubtful)} are in doubt: the run grazes a "
            "reversal or cannot be predicted so far ahead."
        )
        out.append(Warned(code="doubtful_derivatives", parameters=(), text=text))
    return out
