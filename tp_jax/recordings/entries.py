"""Contents of a campaign.toml, before any data file is read."""

import math
import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, cast

from tp_jax.recordings.faults import CampaignError
from tp_jax.recordings.format_section import read_changes, read_format
from tp_jax.recordings.sections import Section, read_toml
from tp_jax.recordings.sources import FileFormat
from tp_jax.recordings.units import FREQUENCY, TIME

Model = Literal["double", "single"]


@dataclass(frozen=True)
class Known:
    """Prior knowledge of a parameter.

    Attributes:
        value: in the parameter's unit.
        sd: standard deviation of the prior; None: the value is fixed.
    """

    value: float
    sd: float | None = None


@dataclass(frozen=True)
class Entry:
    """A `[[recording]]`; attributes as in `Recording`.

    Attributes:
        line: of its heading in the campaign.toml; None where there is none.
        columns: where its columns differ from those of other files, name -> settings.
    """

    name: str
    file: Path
    forced: bool
    omega: float | None = None
    measured_drive: bool = False
    span: tuple[float, float] | None = None
    start: float | None = None
    repeat: str | None = None
    held_out: bool = False
    line: int | None = None
    columns: dict[str, dict[str, Any]] = field(default_factory=dict)


@dataclass(frozen=True)
class Plan:
    """A campaign.toml; attributes as in `Campaign`, model None where it does not say.

    rotates: the column may turn round and round, for want of a spring that would hold it.
    """

    name: str
    model: Model | None = None
    B1: float | None = None
    B2: Known | None = None
    k: Known | None = None
    sample_rate: float | None = None
    rotates: bool = False
    form: FileFormat = field(default_factory=FileFormat)
    entries: tuple[Entry, ...] = ()


def read_plan(file: Path) -> Plan:
    """Reads a campaign.toml.

    Raises:
        CampaignError: it is no TOML, or says something that cannot be.
    """
    top = read_toml(file)
    top.only("name", "rig", "format", "recording")
    rig = top.section("rig") or Section(file, "[rig]", {}, top.lines, 0, 0)
    rig.only("model", "B1", "B2", "k", "sample_rate", "rotates")
    model = rig.text("model")
    if model not in (None, "double", "single"):
        rig.fault(f'model is "{model}"', 'write model = "double" or model = "single"', "model")
    entries = tuple(_entry(section) for section in top.sections("recording"))
    if not entries:
        raise CampaignError(
            file, "the campaign has no recordings", "add a [[recording]] with its file"
        )
    _check_entries(file, entries)
    _check_scale(rig)
    return Plan(
        name=top.text("name") or file.resolve().parent.name,
        model=cast(Model | None, model),
        B1=rig.positive("B1"),
        B2=_known(rig, "B2"),
        k=_known(rig, "k"),
        sample_rate=rig.positive("sample_rate"),
        rotates=bool(rig.flag("rotates")),
        form=read_format(top.section("format")),
        entries=entries,
    )


def _check_scale(rig: Section) -> None:
    """Faults B2 and k without B1: torques are per unit of it then, and numbers in SI are not."""
    for key in ("B2", "k"):
        if key in rig.values and "B1" not in rig.values:
            rig.fault(
                f"{key} is given but B1 is not, and all torques are then per unit of B1",
                f"give B1 as well, or B1 = 1 if {key} is per unit of it",
                key,
            )


def _known(rig: Section, key: str) -> Known | None:
    if not isinstance(rig.values.get(key), dict):
        value = rig.positive(key)
        return None if value is None else Known(value)
    prior = cast(Section, rig.section(key))
    prior.only("value", "sd")
    value, sd = prior.positive("value"), prior.positive("sd")
    if value is None or sd is None:
        rig.fault(
            f"the prior of {key} lacks its {'sd' if sd is None else 'value'}",
            f"write {key} = {{ value = .., sd = .. }}, or a number to fix it",
            key,
        )
    return Known(value, sd)


def _entry(section: Section) -> Entry:
    section.only(
        "file",
        "omega",
        "frequency",
        "period",
        "unit",
        "forced",
        "drive",
        "span",
        "start",
        "repeat",
        "held_out",
        "columns",
    )
    name = section.text("file")
    if name is None:
        section.fault("the [[recording]] names no file", 'add file = "run-13.csv"')
    drive = section.text("drive")
    if drive not in (None, "measured"):
        section.fault(
            f'drive of {name} is "{drive}"', 'write drive = "measured" or remove it', "drive"
        )
    omega, forced = _omega(section, name), section.flag("forced")
    if forced is None:
        if omega is None and drive is None:
            section.fault(
                f"nothing says how {name} was driven",
                "add omega = W and forced = true, or forced = false for a free decay",
            )
        forced = drive is not None or omega != 0.0
    if forced and omega is None and drive is None:
        section.fault(
            f"{name} was forced, but its omega is missing",
            'add omega = W in rad/s, or drive = "measured"',
        )
    if forced and omega is not None and omega <= 0.0:
        section.fault(
            f"{name} was forced, but its omega is {omega:g}",
            "give omega above zero in rad/s, or forced = false for a free decay",
            "omega",
        )
    return Entry(
        name=name,
        file=section.file.parent / name,
        forced=forced,
        omega=omega if forced else None,  # the motor stood still, whatever was commanded
        measured_drive=drive is not None,
        span=_span(section, name),
        start=section.number("start"),
        repeat=section.text("repeat"),
        held_out=bool(section.flag("held_out")),
        line=section.line(),
        columns=read_changes(section.section("columns")),
    )


def _omega(section: Section, name: str) -> float | None:
    """The drive's frequency in rad/s, however it is given."""
    given = [key for key in ("omega", "frequency", "period") if key in section.values]
    if len(given) > 1:
        section.fault(
            f"{given[0]} and {given[1]} of {name} are both given", "remove one of them", given[1]
        )
    if not given:
        if "unit" in section.values:
            section.fault(
                f"{name} has a unit and no frequency", "add omega, frequency or period", "unit"
            )
        return None
    (key,) = given
    units = TIME if key == "period" else FREQUENCY
    factor = section.unit("unit", units)
    if factor is None:
        factor = 1.0 if key != "frequency" else FREQUENCY["Hz"]
    if key == "period":
        return 2.0 * math.pi / (factor * cast(float, section.positive(key)))
    return factor * cast(float, section.number(key))


def _span(section: Section, name: str) -> tuple[float, float] | None:
    span = section.pair("span")
    if span is not None and not span[0] < span[1]:
        kind = "empty" if span[0] == span[1] else "reversed"
        section.fault(
            f"the span [{span[0]:g}, {span[1]:g}] of {name} is {kind}",
            "write span = [from, to] in seconds",
            "span",
        )
    return span


def _check_entries(file: Path, entries: tuple[Entry, ...]) -> None:
    seen: dict[tuple, Entry] = {}
    of_file: dict[str, Entry] = {}
    for entry in entries:
        before = of_file.setdefault(os.path.abspath(entry.file), entry)
        if entry.columns != before.columns:
            raise CampaignError(
                file,
                f"{entry.name} is listed twice, with other columns",
                "write the same columns beside it each time",
                entry.line,
            )
        # Same file however it is written: "a.csv" and "./a.csv".
        first = seen.setdefault((os.path.abspath(entry.file), entry.span), entry)
        if first is not entry:
            raise CampaignError(
                file,
                f"{entry.name} is listed twice with the same span",
                "remove one of the two or give them different spans",
                entry.line,
            )
    if all(entry.held_out for entry in entries):
        raise CampaignError(
            file,
            "every recording is held_out, nothing is left to fit",
            "remove held_out = true from one or more of them",
            entries[0].line,
        )
