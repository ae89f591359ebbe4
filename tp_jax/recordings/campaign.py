"""A campaign: the recordings of one rig, as its campaign.toml lists them."""

import os
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

import numpy as np

from tp_jax.errors import Notice
from tp_jax.recordings.arrays import campaign_fields
from tp_jax.recordings.calibration_error import CalibrationError, read_calibration_error
from tp_jax.recordings.checks import (
    check_recording,
    check_span,
    check_times,
    check_values,
    odd_ones,
)
from tp_jax.recordings.columns import Columns
from tp_jax.recordings.entries import Entry, Known, Model, Plan, read_plan
from tp_jax.recordings.faults import CampaignError
from tp_jax.recordings.formats import FileFormat, read_columns
from tp_jax.recordings.recorded_run import spanned, within
from tp_jax.recordings.recording import Recording
from tp_jax.recordings.short import short
from tp_jax.recordings.started import read_started


@dataclass(frozen=True, eq=False)
class Campaign:
    """Recordings of one rig and what is known of it.

    Attributes:
        name: of the campaign.
        model: "double", or "single" for a column without ring.
        B1: moment of inertia of the column [kg m^2], which fixes the scale; None: not known.
        B2: moment of inertia of the ring [kg m^2], fixed or a prior.
        k: stiffness of the spring [N m/rad], fixed or a prior.
        sample_rate: as stated [Hz]; the recordings agree with it, their times decide.
        recordings: one or more, in the order of the campaign.toml.
        folder: of the campaign.
    """

    name: str
    model: Model
    B1: float | None
    B2: Known | None
    k: Known | None
    sample_rate: float | None
    recordings: tuple[Recording, ...]
    folder: Path

    def __repr__(self) -> str:
        B1 = "no B1" if self.B1 is None else f"B1={self.B1:.6g}"
        labels = [each.label for each in self.recordings]
        return f"Campaign({self.name!r}, {self.model}, {B1}, recordings={short(labels)})"

    @staticmethod
    def from_arrays(
        recordings: "Iterable[Recording | Mapping[str, Any]]", **given: Any
    ) -> "Campaign":
        """A campaign without files.

        Args:
            recordings: each a `Recording`, or the arguments of `Recording.from_arrays` by name.
            **given: name, B1, model ("double" or "single"; found out), and B2 and k, each a number
                that is fixed or a pair (value, standard deviation).

        Raises:
            InputError: they do not make a campaign.
        """
        made = [
            Recording.from_arrays(**{"name": f"run-{i + 1:02d}", **each})
            if isinstance(each, Mapping)
            else each
            for i, each in enumerate(recordings)
        ]
        return Campaign(**campaign_fields(made, **given))

    @property
    def fitted(self) -> tuple[Recording, ...]:
        """The recordings that may be fitted."""
        return tuple(each for each in self.recordings if not each.held_out)

    @property
    def held_out(self) -> tuple[Recording, ...]:
        """The recordings that are only predicted and scored."""
        return tuple(each for each in self.recordings if each.held_out)

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the measured angles."""
        return ("phi1", "phi2") if self.model == "double" else ("phi1",)

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on what reading files did to the rows, each once; a sentence without its end."""
        return tuple(dict.fromkeys(note for each in self.recordings for note in each.notes))

    @property
    def data_sha256(self) -> dict[str, str]:
        """Name of each file -> SHA-256 of its bytes."""
        return {each.name: each.sha256 for each in self.recordings}


def load_campaign(
    path: str | os.PathLike[str], *, omega: float | None = None, decay: bool = False
) -> Campaign:
    """Reads a campaign and checks all of it.

    Args:
        path: a folder with a campaign.toml, the campaign.toml, or a single data file.
        omega: frequency of the drive [rad/s], for a single data file.
        decay: the single data file is a free decay, the motor at rest.

    Raises:
        CampaignError: anything that keeps the campaign from being used, in one sentence.

    Warns:
        Notice: rows of a file were left out, or put elsewhere in time.
    """
    toml, plan = _planned(Path(path), omega, decay)
    campaign = cast(Campaign, _load(toml, plan, _raise))
    for note in campaign.notes:
        warnings.warn(f"{note}.", Notice, stacklevel=2)
    return campaign


def load_what_can_be(
    path: str | os.PathLike[str], *, omega: float | None = None, decay: bool = False
) -> tuple[Campaign | None, list[CampaignError]]:
    """Loads a campaign as `load_campaign` does, but with all faults at once.

    Returns:
        The campaign of the recordings that are without fault, None where there are none, and the
        faults.
    """
    faults: list[CampaignError] = []
    try:
        toml, plan = _planned(Path(path), omega, decay)
        return _load(toml, plan, faults.append), faults
    except CampaignError as fault:
        return None, [*faults, fault]


def _raise(fault: CampaignError) -> None:
    raise fault


def _planned(path: Path, omega: float | None, decay: bool) -> tuple[Path, Plan]:
    """The campaign.toml or single data file, and what is to be read."""
    if not os.path.exists(path):  # False also for what could be no name at all
        raise CampaignError(
            path,
            "there is no such file or folder",
            "name a folder with a campaign.toml, or a data file",
        )
    toml = path / "campaign.toml" if path.is_dir() else path
    if not toml.is_file():
        raise CampaignError(
            toml,
            "there is no such file",
            "write one, or name a single data file with --omega W or --decay",
        )
    if toml.suffix.lower() != ".toml":
        return toml, _plan_of_one(path, omega, decay)
    if omega is not None or decay:
        raise CampaignError(
            toml,
            "--omega and --decay are for a single data file",
            "leave them out, the campaign.toml says how each recording was driven",
        )
    return toml, read_plan(toml)


def _plan_of_one(file: Path, omega: float | None, decay: bool) -> Plan:
    if decay == (omega is not None):
        wrong = "driven and a free decay at once" if decay else "a single file does not say"
        raise CampaignError(
            file,
            f"how the recording was driven is unclear, {wrong}",
            "give either --omega W in rad/s, or --decay",
        )
    if omega is not None and not 0.0 < omega < float("inf"):
        raise CampaignError(
            file,
            f"the drive's frequency is {omega:g}",
            "give --omega W above zero in rad/s, or --decay for a free decay",
        )
    entry = Entry(name=file.name, file=file, forced=not decay, omega=omega)
    return Plan(name=file.stem, entries=(entry,))


def _load(toml: Path, plan: Plan, fault: Callable[[CampaignError], None]) -> Campaign | None:
    """Reads what is planned; a recording whose fault `fault` does not raise is left out."""
    files = _read_files(plan, fault)
    if not files:
        return None
    model = _model(toml, plan, files)
    # where the campaign maps columns of its own, the angles are not those that were calibrated
    own = not plan.form.columns
    appearances = Counter(entry.file for entry in plan.entries)
    made = []
    for entry in plan.entries:
        if entry.file not in files:
            continue
        try:
            errors = read_calibration_error(entry.file) if own else {}
            recording = _recording(toml, entry, files[entry.file], model, errors)
            if appearances[entry.file] > 1 and entry.span is not None:
                recording = replace(recording, label=spanned(entry.name, entry.span))
        except CampaignError as error:
            fault(error)
            continue
        made.append((entry, recording, files[entry.file].thinned))
    odd = None if plan.rotates else odd_ones([each for _, each, _ in made])
    entries, recordings = [], []
    for entry, recording, thinned in made:
        rate = None if thinned else plan.sample_rate  # which is that of the rows
        try:
            check_recording(recording, rate, plan.rotates, recording.sources, odd)
        except CampaignError as error:
            fault(error)
            continue
        entries.append(entry)
        recordings.append(recording)
    if not recordings:  # each has its fault
        return None
    _check_overlaps(toml, entries, recordings)
    if model == "double" and not any(np.ptp(r.phi2) for r in recordings):
        raise CampaignError(
            recordings[0].file,
            f"phi2 is {recordings[0].phi2[0]:g} throughout, and does not move in any recording",
            'check the sensor, or write model = "single" under [rig] if there is no rider',
        )
    return Campaign(
        name=plan.name,
        model=model,
        B1=plan.B1,
        B2=plan.B2,
        k=plan.k,
        sample_rate=plan.sample_rate,
        recordings=tuple(recordings),
        folder=toml.parent,
    )


def _read_files(plan: Plan, fault: Callable[[CampaignError], None]) -> dict[Path, Columns]:
    wanted = {entry.file: ["t", "phi1"] for entry in plan.entries}
    for names in wanted.values():
        if plan.model != "single":
            names.append("phi2")
    for entry in plan.entries:
        if entry.measured_drive and "drive" not in wanted[entry.file]:
            wanted[entry.file].append("drive")
    own = {entry.file: entry.columns for entry in plan.entries}
    files = {}
    for file, names in wanted.items():
        try:
            columns = read_columns(file, _form(plan.form, own[file]), names)
            check_times(columns)
        except CampaignError as error:
            fault(error)
            continue
        files[file] = columns
    return files


def _form(form: FileFormat, own: dict[str, dict[str, Any]]) -> FileFormat:
    """The format of one file: that of all, and what it has of its own."""
    if not own:
        return form
    changes = {
        name: {**form.changes.get(name, {}), **own.get(name, {})}
        for name in {**form.changes, **own}
    }
    return replace(form, changes=changes)


def _model(toml: Path, plan: Plan, files: dict[Path, Columns]) -> Model:
    if plan.model == "single":
        return "single"
    without = [columns for columns in files.values() if "phi2" not in columns.values]
    if plan.model is None and len(without) == len(files):
        return "single"
    if without:
        if plan.form.columns:  # one mapping for all files
            raise CampaignError(
                toml,
                'model is "double", but [format.columns] does not say where phi2 is',
                'add phi2 to it, or write model = "single"',
            )
        raise CampaignError(
            without[0].file,
            'there is no column phi2, which model = "double" needs in every recording'
            if plan.model
            else "there is no column phi2, though other recordings of the campaign have one",
            'add it, or write model = "single" under [rig]',
            without[0].header,
        )
    return "double"


def _recording(
    toml: Path,
    entry: Entry,
    columns: Columns,
    model: Model,
    errors: dict[str, CalibrationError],
) -> Recording:
    if entry.measured_drive and "drive" not in columns.values:
        raise CampaignError(
            entry.file,
            'there is no column drive, which drive = "measured" needs',
            "add it, say where it is under [format.columns], or give omega instead",
            columns.header,
        )
    t = columns.values["t"]
    begin, end = (0, t.size) if entry.span is None else within(t, *entry.span)
    check_span(columns, entry, begin, end, toml)
    check_values(columns, begin, end)
    part = {name: values[begin:end] for name, values in columns.values.items()}
    measured = ("phi1", "phi2") if model == "double" else ("phi1",)
    return Recording(
        name=entry.name,
        label=entry.name,
        file=entry.file,
        t=part["t"],
        phi1=part["phi1"],
        phi2=part["phi2"] if model == "double" else None,
        drive=part["drive"] if entry.measured_drive else None,
        forced=entry.forced,
        omega=entry.omega,
        span=entry.span,
        start=entry.start,
        repeat=entry.repeat,
        held_out=entry.held_out,
        sha256=columns.sha256,
        calibration_error={name: errors[name] for name in measured if name in errors},
        sources={name: each for name, each in columns.sources.items() if name in part},
        notes=columns.notes,
        started=read_started(entry.file),
    )


def _check_overlaps(toml: Path, entries: list[Entry], recordings: list[Recording]) -> None:
    """A held-out span that is fitted as well would make the score worthless."""
    pairs = list(zip(entries, recordings, strict=True))
    for entry, held in pairs:
        if not held.held_out:
            continue
        for _, fitted in pairs:
            if fitted.held_out or fitted.sha256 != held.sha256:
                continue
            # Spans may meet in a sample.
            common = min(held.t[-1], fitted.t[-1]) - max(held.t[0], fitted.t[0])
            if common > 0.01 * min(held.duration, fitted.duration):
                raise CampaignError(
                    toml,
                    f"{common:.3g} s of {held.label}, held_out, are fitted as {fitted.label}",
                    "let the spans of the two entries not overlap",
                    entry.line,
                )
