"""Results as their JSON has them: tables by name, at most a hundred times each."""

from collections.abc import Sequence

import numpy as np

from tp_jax.identifiability.null_directions import Direction
from tp_jax.identifiability.profile_likelihood import Profile
from tp_jax.identifiability.rank import Rank
from tp_jax.results.sensitivity import (
    ByName,
    Columns,
    LocalRun,
    LocalSensitivity,
    MorrisEffects,
    MorrisOfChannel,
    MorrisRun,
    MorrisThroughTime,
    NullDirection,
    ProfileRecord,
    Row,
    SobolIndices,
    SobolOfChannel,
    SobolRun,
    SobolThroughTime,
    StructuralRank,
)
from tp_jax.sensitivity_analysis.local import Local
from tp_jax.sensitivity_analysis.morris import Morris
from tp_jax.sensitivity_analysis.ranges import Range
from tp_jax.sensitivity_analysis.sobol import Sobol

MOST_TIMES = 101
DIGITS = 6


def structural_rank(found: Rank) -> StructuralRank:
    """Ranks and singular values at the random points."""
    return StructuralRank(
        parameters=tuple(found.names),
        recordings=tuple(found.designs),
        points=len(found.points),
        rank=found.rank,
        of=len(found.names),
        ranks=tuple(found.ranks.tolist()),
        gap=found.gap,
        singular_values=tuple(_rounded(row) for row in found.singular_values),
        weakest=tuple(_named(found.names, row) for row in found.weakest),
    )


def null_direction(found: Direction) -> NullDirection:
    """A direction in which nothing is seen."""
    return NullDirection.read(found.to_dict())


def profile_record(found: Profile) -> ProfileRecord:
    """A likelihood profile."""
    return ProfileRecord.read(found.to_dict())


def local_sensitivity(runs: Sequence[Local], scale: dict[str, float]) -> LocalSensitivity:
    """Derivatives through time [rad per relative change], and their rms."""
    out = []
    for r in runs:
        pick = np.unique(np.linspace(0, r.t.size - 1, MOST_TIMES).round().astype(int))
        out.append(
            LocalRun(
                recording=r.label,
                t=_rounded(r.t[pick]),
                **{c: _columns(r.names, e[pick]) for c, e in r.effect.items()},
                rms={c: _named(r.names, x) for c, x in r.rms.items()},
                reliable={n: bool(x) for n, x in zip(r.names, r.reliable, strict=True)},
                growth=float(r.growth),
            )
        )
    return LocalSensitivity(
        unit="rad per relative change of the parameter",
        scale={n: float(x) for n, x in scale.items()},
        rms=_largest(runs[0].names, [r.rms for r in runs]),
        recordings=tuple(out),
    )


def sobol_indices(runs: Sequence[Sobol], over: Sequence[Range], samples: int) -> SobolIndices:
    """Indices of each recording, whole and through time."""
    out = []
    for r in runs:
        tables = {
            c: SobolOfChannel(
                first=_named(r.names, r.first_whole[c]),
                first_error=_named(r.names, r.first_error[c]),
                total=_named(r.names, r.total_whole[c]),
                total_error=_named(r.names, r.total_error[c]),
                through_time=SobolThroughTime(
                    variance=_rounded(r.variance[c]),
                    first=_columns(r.names, r.first[c]),
                    total=_columns(r.names, r.total[c]),
                ),
            )
            for c in r.first
        }
        out.append(SobolRun(recording=r.label, t=_rounded(r.t), runs=r.runs, **tables))
    return SobolIndices(
        ranges={r.name: (r.low, r.high) for r in over},
        samples=samples,
        first=_largest(runs[0].names, [r.first_whole for r in runs]),
        total=_largest(runs[0].names, [r.total_whole for r in runs]),
        recordings=tuple(out),
    )


def morris_effects(runs: Sequence[Morris], over: Sequence[Range], count: int) -> MorrisEffects:
    """Elementary effects of each recording, whole and through time."""
    out = []
    for r in runs:
        tables = {
            c: MorrisOfChannel(
                mu_star=_named(r.names, r.mu_star_whole[c]),
                mu_star_conf=_named(r.names, r.mu_star_error[c]),
                sigma=_named(r.names, r.sigma_whole[c]),
                through_time=MorrisThroughTime(
                    mu_star=_columns(r.names, r.mu_star[c]),
                    sigma=_columns(r.names, r.sigma[c]),
                ),
            )
            for c in r.mu_star
        }
        out.append(MorrisRun(recording=r.label, t=_rounded(r.t), runs=r.runs, **tables))
    return MorrisEffects(
        unit="rad per whole range of the parameter",
        ranges={r.name: (r.low, r.high) for r in over},
        trajectories=count,
        mu_star=_largest(runs[0].names, [r.mu_star_whole for r in runs]),
        recordings=tuple(out),
    )


def _largest(names: Sequence[str], tables: Sequence[dict[str, np.ndarray]]) -> dict[str, ByName]:
    """Channel -> parameter -> the largest of all recordings."""
    return {c: _named(names, np.max([t[c] for t in tables], axis=0)) for c in tables[0]}


def _named(names: Sequence[str], row: np.ndarray) -> ByName:
    return dict(zip(names, _rounded(row), strict=True))


def _columns(names: Sequence[str], table: np.ndarray) -> Columns:
    return {n: _rounded(table[:, i]) for i, n in enumerate(names)}


def _rounded(row: np.ndarray) -> Row:
    """Rounds to six digits: more would be the solver's, and twice the file."""
    values = np.asarray(row, float).tolist()
    return tuple(float(f"{x:.{DIGITS}g}") if np.isfinite(x) else None for x in values)
