"""Output of `tp-jax identify --json`, version 1; SI units, angles in rad."""

from dataclasses import dataclass, field
from typing import Annotated

from tp_jax.results.encoding import Record, Schema
from tp_jax.results.sizes import Correlation, Interval, Size
from tp_jax.schemas import parts

VERSION = "tp-jax/identify/1"


@dataclass(frozen=True, kw_only=True)
class StartRecord(Record):
    """End of a start: objective None where the motion could not be integrated from it."""

    objective: float | None
    converged: bool
    evaluations: int
    message: str


@dataclass(frozen=True, kw_only=True)
class SuccessRecord(Record):
    """Starts that reached the best, of how many; the probability of it with its interval.

    expected_evaluations: passes over the data until one does; None where none did.
    """

    reached: int
    of: int
    probability: float | None = None
    ci95: Interval | None = None
    expected_evaluations: float | None = None


@dataclass(frozen=True, kw_only=True)
class Warned(Record):
    """A warning: its code, the parameters that it is about, and a sentence."""

    code: str
    parameters: tuple[str, ...] = ()
    text: str


@dataclass(frozen=True, kw_only=True)
class IdentifyProvenance(Record):
    """Origin of the numbers.

    eps: the friction's smoothing [s/rad]; horizon_s: length of the windows [s]; wall_s [s].
    """

    version: str = ""
    seed: Annotated[int | None, Schema(parts.NUMBER_OR_NULL)] = None
    data_sha256: dict[str, str] = field(default_factory=dict)
    eps: float | None = None
    horizon_s: float | None = None
    loss: str = ""
    noise: str = ""
    sampling: str = ""
    raw_starts: bool | None = None
    wall_s: float | None = None


@dataclass(frozen=True, kw_only=True)
class IdentificationRecord(Record):
    """An identification as its JSON has it.

    Attributes:
        sizes: parameter -> value, interval, and whether the data identify it.
        objective: chi-square, or (17) in a search on free runs.
        noise_floor: by channel [rad].
    """

    schema: str = VERSION
    campaign: str = ""
    model: str
    method: str
    objective_kind: str = ""
    sizes: dict[str, Size] = field(metadata={"key": "parameters"})
    correlation: Correlation | None = None
    objective: float | None
    chi2_dof: float | None = None
    noise_floor: dict[str, float | None] = field(default_factory=dict)
    starts: tuple[StartRecord, ...]
    success: SuccessRecord
    warnings: tuple[Warned, ...]
    provenance: IdentifyProvenance = field(default_factory=IdentifyProvenance)
