"""Contents of diagnosis.json, version 1: the types of it, from which its schema is made too.

SI units, angles in rad. What nobody could say is None; a file may lack all but `fits`.
"""

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal, TypeVar

from tp_jax.results.encoding import Record, Schema, schema_of
from tp_jax.results.sizes import Correlation, Interval, Size
from tp_jax.schemas import parts
from tp_jax.schemas.checking import check, check_version, json_of, read_json

VERSION = "tp-jax/diagnosis/1"
CHANNELS = {"phi1": "φ1", "phi2": "φ2"}

Verdict = Literal["explained", "no_gap", "unknown"]
Numbers = Annotated[
    tuple[float | None, ...], Schema(type=["array", "null"], says="a list of numbers or null")
]
"""Readings in the order of time, None where there is none; their entries are not checked."""
Amplitude = Annotated[
    float | dict[str, float],
    Schema(
        type=["number", "object"],
        additionalProperties=parts.NUMBER,
        minProperties=1,
        says="a number, or a table of one for each recording",
    ),
]
State = tuple[float, float, float, float]
"""φ1, φ2 [rad] and their velocities [rad/s]."""

_COLUMN = ("B1", "k", "A", "c1", "M1")
_RIDER = ("B2", "Tv", "Ts1", "Ts2", "Tst", "T0")
_ABOVE_ZERO = {n: parts.ABOVE_ZERO for n in ("B1", "B2", "k", "T0")}
_NUMBER_OF = {n: parts.NUMBER for n in (*_COLUMN, *_RIDER)}


@dataclass(frozen=True)
class Errors(Record):
    """Errors on held-out data, root mean square [rad]: in windows, and of a free run."""

    windowed: float | None = None
    free_run: float | None = None


@dataclass(frozen=True)
class LackOfFit(Record):
    """The test without hypotheses.

    p: over all sources; source: the one that stands out most, "" if none was asked; ratio: its T
    over what noise alone would give.
    """

    p: float
    source: str = ""
    ratio: float | None = None


@dataclass(frozen=True)
class LackOfFits(Record):
    """The same test of the model before, and after the causes are added."""

    before: LackOfFit | None = None
    after: LackOfFit | None = None


@dataclass(frozen=True)
class Misfits(Record):
    """Chi-square per degree of freedom of both fits."""

    before: float | None = None
    after: float | None = None


@dataclass(frozen=True)
class Gap(Record):
    """Size of the gap on held-out data, and how far it shrinks.

    Attributes:
        shrink: the part of the removable gap that is gone; None where there is too little of it.
        horizon_s: length of the windows [s].
        removable_significant: whether the gap stands out from the noise floor.
        structure_p, structure_p_after: of the tests of structure, before and after; the first is of
            the prediction of held-out recordings where that alone rejects.
        excess_z: standard errors by which the misfit exceeds the floor.
        unpredicted: whether the gap shows in held-out recordings alone: fitted ones leave nothing
            but noise, do not predict them, and no cause was found.
        tolerance: root mean square [rad] below which a gap does not count.
        rejected: ids of effects that were chosen and are no causes.
    """

    before: Errors = Errors()
    after: Errors = Errors()
    shrink: float | None = None
    shrink_ci95: Interval | None = None
    shrink_by_recording: dict[str, float | None] = field(default_factory=dict)
    held_out: tuple[str, ...] = ()
    horizon_s: float | None = None
    removable_significant: bool | None = None
    structure_p: float | None = None
    structure_p_after: float | None = None
    free_structure: LackOfFits = LackOfFits()
    excess_z: float | None = None
    unpredicted: bool = False
    tolerance: float | None = None
    rejected: tuple[str, ...] = ()
    chi2_dof: Misfits = Misfits()


@dataclass(frozen=True)
class ChannelNoise(Record):
    """The noise of a channel: sd [rad], its coloured part, the sensor's step [rad], its source."""

    sd: float | None = None
    white: float | None = None
    ar: tuple[float, ...] = ()
    lag_one: float | None = None
    quantum: float | None = None
    source: str = field(default="", metadata={"key": "from"})


@dataclass(frozen=True)
class FloorParts(Record):
    """Parts of the noise floor, by channel [rad]."""

    noise: dict[str, float | None] = field(default_factory=dict)
    calibration: dict[str, float | None] = field(default_factory=dict)


@dataclass(frozen=True)
class Location(Record):
    """A place in the rig, its share of the gap, and the part of the motion in which it shows.

    share_ci95: of its channel, where that was found without a cause.
    """

    location: str
    channel: str = ""
    share: float | None = None
    when: str | None = None
    share_ci95: Interval | None = None


@dataclass(frozen=True)
class Visited(Record):
    """Spread of the samples over a law's argument: edges (b + 1,) of bins, share (b,) of each."""

    edges: tuple[float, ...] = ()
    share: tuple[float, ...] = ()


@dataclass(frozen=True)
class Curve(Record):
    """A learned law: x in `unit`, y in `y_unit`, and the ends of its band at 95 %."""

    argument: str = ""
    unit: str = ""
    x: tuple[float, ...] = field(kw_only=True)
    y: tuple[float, ...] = field(kw_only=True)
    y_unit: str = ""
    ci95: tuple[Interval, ...] = ()
    visited: Visited = Visited()


@dataclass(frozen=True)
class Agreement(Record):
    """In how many recordings a cause improves the fit, and in which it makes it worse.

    drops: label -> fall of the sum of squares there [variances of the noise]: of a fitted recording
    under numbers fitted without the windows that are looked at, of a held-out one in windows.
    """

    improved: int | None = None
    of: int | None = None
    worse: tuple[str, ...] = ()
    drops: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Cause(Record):
    """An accepted cause.

    Attributes:
        kind: "catalogue" or "learned".
        probability: that the effect is there, given the data.
        shrink: the part of the removable gap that is gone with it and those before it.
        parameters: amplitudes and shape constants.
        remedy, by_hand: what to do about it, and how to check it, as clauses.
        formula, curve: of a learned law.
    """

    effect: str
    kind: str = ""
    location: str = ""
    channel: str = ""
    probability: float | None = None
    shrink: float | None = None
    parameters: dict[str, Size] = field(default_factory=dict)
    remedy: str = ""
    by_hand: str = ""
    formula: str | None = None
    curve: Curve | None = None
    agreement: Agreement | None = None


@dataclass(frozen=True)
class Candidate(Record):
    """An effect or a law that was asked about, alone; note: why it is no cause."""

    effect: str
    location: str = ""
    channel: str = ""
    applicable: bool | None = None
    predicted_shrink: float | None = None
    realised_shrink: float | None = None
    probability: float | None = None
    p: float | None = None
    note: str | None = None

    @property
    def judged(self) -> bool:
        """True where anything is known of it."""
        numbers = (self.predicted_shrink, self.realised_shrink, self.probability)
        return any(x is not None for x in numbers) or bool(self.note)


@dataclass(frozen=True)
class Shift(Record):
    """Shift of a parameter that had been pulled aside: baseline minus refitted, in its unit."""

    shift: float | None = None
    in_standard_errors: float | None = None
    unit: str = ""


@dataclass(frozen=True)
class Nuisances(Record):
    """Phase [rad], gain and level of the drive; zeros of the sensors [rad], φ2's by recording; by
    how much the spring is wound at rest [rad]."""

    phase: float
    gain: float
    level: float
    zero1: float
    zero2: Annotated[
        dict[str, float],
        Schema(minProperties=1, says="a table of one number for each recording"),
    ]
    preload: float = 0.0


@dataclass(frozen=True)
class ModelFit(Record):
    """Everything that a prediction needs of a fitted model.

    Attributes:
        kind: "single" or "double".
        reaction: part of the contact's torque that the column receives.
        eps: the friction's smoothing [s/rad].
        drift: label -> middle [s] and rate [1/s] of the recording's clock.
        effects: id -> its numbers; an amplitude may have one for each recording.
        elsewhere: id -> of such amplitudes, what the fitted recordings let expect of another.
    """

    kind: Literal["single", "double"]
    parameters: Annotated[
        dict[str, float], Schema(parts.table({**_NUMBER_OF, **_ABOVE_ZERO}, _COLUMN))
    ]
    reaction: float
    eps: Annotated[float, Schema(parts.ABOVE_ZERO)]
    nuisances: Nuisances
    drift: dict[str, tuple[float, float]] | None = None
    effects: dict[str, dict[str, Amplitude]] = field(kw_only=True)
    elsewhere: dict[str, dict[str, float]] = field(default_factory=dict, kw_only=True)


# a rider has numbers of its own
_Fit = Annotated[
    ModelFit,
    Schema(
        {
            "if": {"properties": {"kind": {"const": "double"}}, "required": ["kind"]},
            "then": {"properties": {"parameters": {"required": [*_RIDER]}}},
        }
    ),
]


@dataclass(frozen=True)
class Fits(Record):
    """The model before the causes are added, and after; None where no cause was accepted."""

    before: _Fit
    after: _Fit | None


@dataclass(frozen=True)
class NextExperiment(Record):
    """A run that would tell two effects apart.

    Attributes:
        omega: frequency of the drive [rad/s]; phi1: release of a decay [rad]; duration [s].
        separates: ids of the effects.
        expected_sigma: standard errors by which the two, each as large as the data make it, differ
            on that run alone, everything else re-optimised.
    """

    omega: float | None = None
    phi1: float | None = None
    forced: bool | None = None
    duration: float | None = None
    separates: tuple[str, ...] = ()
    expected_sigma: float | None = None


@dataclass(frozen=True)
class Start(Record):
    """State at the start of a held-out recording, as each of the models has it."""

    before: State | None = None
    after: State | None = None


@dataclass(frozen=True)
class RecordingUsed(Record):
    """A recording that a diagnosis used; begin, duration [s], omega [rad/s]."""

    label: str
    file: str = ""
    sha256: str = ""
    held_out: bool | None = None
    forced: bool | None = None
    omega: float | None = None
    begin: float | None = None
    duration: float | None = None
    samples: int | None = None
    started: str | None = None
    start: Start = Start()


@dataclass(frozen=True)
class Series(Record):
    """One channel over time: measured [rad] and the models; residuals are in units of the floor."""

    measured: Numbers | None = None
    before: Numbers | None = None
    after: Numbers | None = None


@dataclass(frozen=True)
class HeldOutRun(Record):
    """Curves that a report draws of a held-out recording, over the times t [s]."""

    recording: str = ""
    t: Numbers | None = None
    phi1: Series | None = None
    phi2: Series | None = None


@dataclass(frozen=True)
class Provenance(Record):
    """Origin of the numbers: version, seed, SHA-256 of each file, computing time [s]."""

    version: str = ""
    seed: Annotated[int | None, Schema(parts.NUMBER_OR_NULL)] = None
    data_sha256: dict[str, str] = field(default_factory=dict)
    wall_s: float | None = None


Read = TypeVar("Read", bound="DiagnosisRecord")


@dataclass(frozen=True, kw_only=True)
class DiagnosisRecord(Record):
    """A diagnosis as diagnosis.json has it.

    Attributes:
        campaign, model: of what, and which baseline: "newton" or "paper".
        verdict: "explained", "no_gap" or "unknown"; None where a file does not say.
        noise_floor: by channel [rad].
        where: places of the gap, largest share first.
        accepted: the causes, in order of contribution.
        candidates: the whole catalogue, most probable first.
        confused_with: groups of effects that these data cannot tell apart.
        minimum_detectable: id -> size that these data would have shown.
        absorbed: parameter -> how far it had been pulled aside.
        fits: both models, for predictions; None where a file lacks them.
        curves, residuals: held-out recordings, thinned.
    """

    schema: str = VERSION
    campaign: str = ""
    model: str = ""
    verdict: Verdict | None = None
    noise_floor: dict[str, float | None] = field(default_factory=dict)
    noise: dict[str, ChannelNoise] = field(default_factory=dict)
    noise_floor_parts: FloorParts = field(default_factory=FloorParts)
    gap: Gap = field(default_factory=Gap)
    where: tuple[Location, ...] = ()
    accepted: tuple[Cause, ...] = field(default=(), metadata={"key": "causes"})
    candidates: tuple[Candidate, ...] = ()
    confused_with: tuple[tuple[str, ...], ...] | None = None
    minimum_detectable: dict[str, Size] = field(default_factory=dict)
    absorbed: dict[str, Shift] = field(default_factory=dict)
    fits: Fits | None = None
    parameters: dict[str, Size] = field(default_factory=dict)
    correlation: Correlation | None = None
    next_experiment: NextExperiment | None = None
    recordings: tuple[RecordingUsed, ...] = ()
    curves: tuple[HeldOutRun, ...] = ()
    residuals: tuple[HeldOutRun, ...] = ()
    notes: tuple[str, ...] = ()
    provenance: Provenance = field(default_factory=Provenance)

    @classmethod
    def from_json(cls: type[Read], source: str | os.PathLike[str], *, fits: bool = True) -> Read:
        """The diagnosis that a file holds.

        Args:
            source: a diagnosis.json, or its text, which begins with a brace.
            fits: whether they have to be there; nothing is predicted without.

        Raises:
            InputError: it cannot be read, is of another version, or a field is not what it must
                be; the sentence names the field.
        """
        text = isinstance(source, str) and source.lstrip("\ufeff \t\r\n").startswith("{")
        name = "The diagnosis" if text else os.fspath(source)
        content = json_of(str(source).removeprefix("\ufeff"), name) if text else read_json(name)
        check_version(content, VERSION, name, "a diagnosis", "diagnose the campaign again")
        check(content, SCHEMA if fits else WITHOUT_FITS, name)
        return cls.from_dict(content)

    @property
    def causes(self) -> list[str]:
        """Ids of the accepted causes, in order of contribution."""
        return [cause.effect for cause in self.accepted]

    @property
    def applicable(self) -> list[Candidate]:
        """Candidates that apply to this campaign, most probable first."""
        return [row for row in self.candidates if row.applicable is not False]

    @property
    def groups(self) -> list[list[str]]:
        """Groups of effects that these data cannot tell apart, two or more in each."""
        named = [[name for name in group if name] for group in self.confused_with or ()]
        return [group for group in named if len(group) > 1]

    @property
    def floor(self) -> float | None:
        """Noise floor over the channels [rad]: the root of the mean of their squares."""
        found = [self.noise_floor.get(channel) for channel in CHANNELS]
        squares = [x * x for x in found if x is not None]
        return math.sqrt(sum(squares) / len(squares)) if squares else None

    @property
    def states(self) -> tuple[Literal["before", "after"], ...]:
        """before and after; before alone where nothing was added, or no error after is known."""
        after = self.gap.after
        known = after.windowed is not None or after.free_run is not None
        return ("before", "after") if known and self.accepted else ("before",)

    @property
    def recorded(self) -> list[str]:
        """First and last day on which its recordings were made, once where they are the same.

        Empty where their metadata do not say.
        """
        known = sorted(filter(None, ((run.started or "")[:10] for run in self.recordings)))
        return list(dict.fromkeys([known[0], known[-1]])) if known else []

    def tied_with(self, effect: str) -> list[str]:
        """The others of all groups in which this effect is."""
        others = [name for group in self.groups if effect in group for name in group]
        return [name for name in dict.fromkeys(others) if name != effect]


WITHOUT_FITS: dict[str, Any] = {
    "$schema": "https://json-schema.org/draft/2020-12/schema",
    "title": VERSION,
    **schema_of(DiagnosisRecord),
}
"""The JSON schema of a diagnosis that is only looked at."""

SCHEMA = {
    **WITHOUT_FITS,
    "properties": {**WITHOUT_FITS["properties"], "fits": schema_of(Fits)},  # null is none
    "required": ["fits"],
}
"""The JSON schema of diagnosis.json."""

Found = DiagnosisRecord | Mapping[str, Any]
"""A diagnosis, or the dictionary of it."""
