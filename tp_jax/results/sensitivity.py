"""Output of `tp-jax sensitivity --json`, version 1; SI units, angles in rad.

A table by parameter has one column for each; what is no finite number is None.
"""

from dataclasses import dataclass, field
from typing import Generic, TypeVar

from tp_jax.results.encoding import Record
from tp_jax.results.identification import Warned
from tp_jax.results.sizes import Interval

VERSION = "tp-jax/sensitivity/1"

Row = tuple[float | None, ...]
ByName = dict[str, float | None]
"""Parameter -> number."""
Columns = dict[str, Row]
"""Parameter -> numbers (t,) through time."""


Table = TypeVar("Table")


class ByChannel(Generic[Table]):
    """A part with the same table for each measured channel."""

    phi1: Table
    phi2: Table | None

    @property
    def channels(self) -> dict[str, Table]:
        """Table by channel; a column alone has no phi2."""
        both = {"phi1": self.phi1, "phi2": self.phi2}
        return {name: table for name, table in both.items() if table is not None}


@dataclass(frozen=True, kw_only=True)
class KnownParameter(Record):
    """A parameter: its value, and whether it can be known.

    given: beforehand; structural: by any recordings of these angles; practical: by these;
    identifiable: both.
    """

    value: float
    unit: str
    ci95: Interval | None
    standard_error: float | None
    given: bool
    structural: bool
    practical: bool
    identifiable: bool


@dataclass(frozen=True, kw_only=True)
class NullDirection(Record):
    """Parameters that can change together unseen, with the coefficients of their logarithms.

    sd_log: how far, None without end; removed_by: what stops it, None where nothing does.
    """

    parameters: dict[str, float]
    kind: str
    sd_log: float | None
    removed_by: str | None
    text: str


@dataclass(frozen=True, kw_only=True)
class StructuralRank(Record):
    """Ranks (p,) and singular values (p, q) at random points; weakest: (p,) their directions."""

    parameters: tuple[str, ...]
    recordings: tuple[str, ...]
    points: int
    rank: int
    of: int
    ranks: tuple[int, ...]
    gap: float | None
    singular_values: tuple[Row, ...]
    weakest: tuple[ByName, ...]


@dataclass(frozen=True, kw_only=True)
class EstimateCorrelation(Record):
    """Correlations of the errors of parameters: names (q,), matrix (q, q)."""

    names: tuple[str, ...] = field(metadata={"key": "parameters"})
    matrix: tuple[Row, ...]


@dataclass(frozen=True, kw_only=True)
class LocalRun(Record, ByChannel[Columns]):
    """Derivatives along a recording at times t (t,), and their root mean square.

    reliable: whether a derivative holds along the whole of it; growth: of a small error.
    """

    recording: str
    t: Row
    phi1: Columns
    phi2: Columns | None = None
    rms: dict[str, ByName]
    reliable: dict[str, bool]
    growth: float | None


@dataclass(frozen=True, kw_only=True)
class LocalSensitivity(Record):
    """Derivatives of all recordings; rms: channel -> parameter -> the largest of them."""

    unit: str
    scale: dict[str, float]
    rms: dict[str, ByName]
    recordings: tuple[LocalRun, ...]


@dataclass(frozen=True, kw_only=True)
class SobolThroughTime(Record):
    """Variance (t,) of an angle [rad^2], and the part of it that each parameter has."""

    variance: Row
    first: Columns = field(metadata={"key": "S1"})
    total: Columns = field(metadata={"key": "ST"})


@dataclass(frozen=True, kw_only=True)
class SobolOfChannel(Record):
    """Indices of a whole recording, of first order and total, with half their 95 % intervals."""

    first: ByName = field(metadata={"key": "S1"})
    first_error: ByName = field(metadata={"key": "S1_conf"})
    total: ByName = field(metadata={"key": "ST"})
    total_error: ByName = field(metadata={"key": "ST_conf"})
    through_time: SobolThroughTime


@dataclass(frozen=True, kw_only=True)
class SobolRun(Record, ByChannel[SobolOfChannel]):
    """Indices of a recording at times t (t,), from so many runs."""

    recording: str
    t: Row
    runs: int
    phi1: SobolOfChannel
    phi2: SobolOfChannel | None = None


@dataclass(frozen=True, kw_only=True)
class SobolIndices(Record):
    """Indices over ranges of the parameters; of first order and total: the largest of all runs."""

    ranges: dict[str, tuple[float, float]]
    samples: int
    first: dict[str, ByName] = field(metadata={"key": "S1"})
    total: dict[str, ByName] = field(metadata={"key": "ST"})
    recordings: tuple[SobolRun, ...]


@dataclass(frozen=True, kw_only=True)
class MorrisThroughTime(Record):
    """Means of sizes, and spreads, of the elementary effects [rad]."""

    mu_star: Columns
    sigma: Columns


@dataclass(frozen=True, kw_only=True)
class MorrisOfChannel(Record):
    """The same of a whole recording, the means with half their 95 % intervals."""

    mu_star: ByName
    mu_star_conf: ByName
    sigma: ByName
    through_time: MorrisThroughTime


@dataclass(frozen=True, kw_only=True)
class MorrisRun(Record, ByChannel[MorrisOfChannel]):
    """Elementary effects of a recording at times t (t,), from so many runs."""

    recording: str
    t: Row
    runs: int
    phi1: MorrisOfChannel
    phi2: MorrisOfChannel | None = None


@dataclass(frozen=True, kw_only=True)
class MorrisEffects(Record):
    """Elementary effects over ranges of the parameters; mu_star: the largest of all recordings."""

    unit: str
    ranges: dict[str, tuple[float, float]]
    trajectories: int
    mu_star: dict[str, ByName]
    recordings: tuple[MorrisRun, ...]


@dataclass(frozen=True, kw_only=True)
class ProfileRecord(Record):
    """A likelihood profile: by how much the misfit rises where the parameter is held at values.

    values, drops: (n,); level: the rise from which a value is rejected; inflation: by how much it
    is above that for noise alone.
    """

    value: float
    unit: str
    ci95: Interval
    identifiable: bool
    values: Row
    drops: Row
    level: float
    inflation: float


@dataclass(frozen=True, kw_only=True)
class FitQuality(Record):
    """Fit at which sensitivities were taken; noise_floor: by channel [rad]."""

    chi2_dof: float
    converged: bool
    message: str
    noise_floor: dict[str, float]


@dataclass(frozen=True, kw_only=True)
class SensitivityProvenance(Record):
    """Origin of the numbers.

    eps: the friction's smoothing [s/rad]; horizon_s: length of the windows [s]; spread: factor of
    the ranges; wall_s [s].
    """

    version: str
    seed: int
    data_sha256: dict[str, str]
    eps: float
    horizon_s: float
    spread: float
    wall_s: float


@dataclass(frozen=True, kw_only=True)
class SensitivityRecord(Record):
    """A sensitivity analysis as its JSON has it.

    Attributes:
        identifiable: parameter -> whether these recordings tell it.
        quality: of the fit, "fit" in the JSON.
        profile: parameter -> its likelihood profile, of those that were asked for.
    """

    schema: str = VERSION
    campaign: str
    model: str
    identifiable: dict[str, bool]
    parameters: dict[str, KnownParameter]
    null_directions: tuple[NullDirection, ...]
    structural: StructuralRank
    correlation: EstimateCorrelation
    local: LocalSensitivity
    sobol: SobolIndices
    morris: MorrisEffects
    profile: dict[str, ProfileRecord]
    quality: FitQuality = field(metadata={"key": "fit"})
    warnings: tuple[Warned, ...]
    provenance: SensitivityProvenance
