"""The rounds of an exploration: a run, its diagnosis, the next run.

The loop knows neither ports nor models: it is handed something that records and something that
diagnoses.
"""

import dataclasses
import hashlib
import json
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from tp_jax._files import bytes_of
from tp_jax.acquisition.campaign_entry import (
    CAMPAIGN,
    Entry,
    append_entry,
    check_campaign,
    entries_of,
    free_name,
)
from tp_jax.acquisition.recorder import uninterrupted
from tp_jax.acquisition.run_log import Recorded
from tp_jax.errors import InputError, Notice
from tp_jax.exploring.amplitudes import metadata_of
from tp_jax.exploring.state import Made, State, read, write
from tp_jax.gap.next_run import Finding, Limits, Next, Run, Stop, first_run, next_run
from tp_jax.gap.policy import POLICY, ExplorePolicy

SCHEMA = "tp-jax/explore/1"

Record = Callable[[Run, Path], Recorded]
"""Has the rig make a run, and writes it to a file that is not there yet."""

Diagnose = Callable[[Path], Finding]
"""Diagnoses a campaign's folder, and forecasts the runs that may come next."""


@dataclasses.dataclass(frozen=True)
class Explored:
    """Result of an exploration.

    Attributes:
        campaign: name of the folder. runs: those it made. finding: of the last diagnosis.
        stop: why it ended.
    """

    campaign: str
    runs: tuple[Made, ...]
    finding: Finding
    stop: Stop

    def to_dict(self) -> dict[str, Any]:
        """Returns it as `tp-jax explore --json` writes it."""
        return {
            "schema": SCHEMA,
            "campaign": self.campaign,
            "runs": [
                {
                    "file": made.file,
                    "omega": made.run.omega,
                    "release": made.run.release,
                    "predicted_largest": None if made.forecast is None else made.forecast.largest,
                    "expected_log_evidence": dict(
                        {} if made.forecast is None else made.forecast.log_evidence
                    ),
                    "verdict": made.verdict,
                    "first": made.first,
                    "probability": made.probability,
                }
                for made in self.runs
            ],
            "verdict": self.finding.verdict,
            "causes": [{"effect": id, "probability": p} for id, p in self.finding.causes],
            "stopped": self.stop.reason,
            "sentence": self.stop.sentence,
        }


def explore(
    folder: Path,
    record: Record,
    diagnose: Diagnose,
    *,
    limits: Limits,
    most: int,
    duration: float,
    amplitude: float | None = None,
    diagnosed: Callable[[Made | None, int, Finding], None] | None = None,
    policy: ExplorePolicy = POLICY.explore,
) -> Explored:
    """Records and diagnoses until the cause is known, or a further run is not worth it.

    Recordings that the campaign has already count as runs. The same call goes on where another one
    was cut off.

    Args:
        folder: of the campaign; may be new.
        record: makes a run. diagnose: judges all of them.
        limits: of the rig. most: recordings at most.
        duration: of a run [s]. amplitude: of the drive [rad]; None: the rig's own.
        diagnosed: called after every diagnosis with the last run, the number of recordings and what
            was found; the run is None where the recordings were there before.
        policy: of the choice.

    Raises:
        InputError: a recording cannot be made or used, in a sentence; the next call goes on.
        KeyboardInterrupt: a recording was ended by Ctrl-C; it is kept.
    """
    check_campaign(folder)
    folder.mkdir(parents=True, exist_ok=True)
    state = _recovered(folder, read(folder))
    asked = json.loads(
        json.dumps(
            {
                "omega": limits.omega,
                "drives": limits.drives,
                "releases": limits.releases,
                "duration": duration,
                "amplitude": amplitude,
            }
        )
    )
    while True:
        entries = entries_of(folder)
        names = [entry.name for entry in entries]
        of = {"files": names, "sha256": _digest(folder, entries), **asked}
        if entries and (state.finding is None or state.diagnosed != of):
            # forecasts for another amplitude, or other frequencies, say nothing of those asked for
            held = state.diagnosed is not None and asked.items() <= state.diagnosed.items()
            before = state.finding if held else None
            finding = _diagnosed(folder, diagnose, before, len(entries), policy)
            runs = state.runs
            last = None
            if runs and runs[-1].file == names[-1]:
                last = dataclasses.replace(
                    runs[-1],
                    verdict=finding.verdict,
                    first=finding.first,
                    probability=finding.probability if finding.first is not None else None,
                )
                runs = (*runs[:-1], last)
            state = State(runs, None, finding, of)
            write(folder, state)
            if diagnosed is not None:
                diagnosed(last, len(entries), finding)
        forecast, run = None, None
        if entries:
            assert state.finding is not None
            made = [_made_run(entry) for entry in entries]
            step = next_run(state.finding, limits, made, most, duration, policy)
            if isinstance(step, Stop):
                return Explored(folder.resolve().name, state.runs, state.finding, step)
            assert isinstance(step, Next)
            forecast, run = step.forecast, step.forecast.run
        else:
            run = first_run(limits, policy)
        out = free_name(folder, run.omega)
        planned = Made(out.name, run, forecast)
        write(folder, dataclasses.replace(state, next=planned))
        _recorded(folder, record, planned)
        state = dataclasses.replace(state, runs=(*state.runs, planned), next=None)
        write(folder, state)


def _diagnosed(
    folder: Path, diagnose: Diagnose, before: Finding | None, number: int, policy: ExplorePolicy
) -> Finding:
    """The finding of all recordings so far.

    Where the first few cannot be diagnosed together, which is a `Notice`, another run may help: the
    forecasts of before stand, and nothing is known of causes.
    """
    try:
        return diagnose(folder)
    except InputError as fault:
        if before is None or number >= policy.survey:
            raise
        warnings.warn(
            f"The {number} recordings so far cannot be diagnosed, another one is made. {fault}",
            Notice,
            stacklevel=2,
        )
        return Finding("unknown", forecasts=before.forecasts)


def _recovered(folder: Path, state: State) -> State:
    """The state after a program was killed: the run that it recorded is made, or was not."""
    if state.next is None:
        return state
    files = {entry.name for entry in entries_of(folder)}
    made = (state.next,) if state.next.file in files else ()
    return dataclasses.replace(state, runs=(*state.runs, *made), next=None)


def _recorded(folder: Path, record: Record, planned: Made) -> None:
    """Records a run and adds it to the campaign."""
    recorded = record(planned.run, folder / planned.file)
    with uninterrupted():
        unfit = append_entry(folder, recorded)
    if recorded.state == "interrupted":
        raise KeyboardInterrupt
    if unfit is not None:
        raise InputError(
            f"{recorded.path} was recorded, but not added to the campaign {folder}: {unfit}"
        )
    if recorded.fault is not None:
        raise InputError(recorded.fault)


def _digest(folder: Path, entries: Sequence[Entry]) -> str:
    """Digest of the campaign.toml and its recordings: a corrected one is diagnosed again."""
    digest = hashlib.sha256()
    for file in (folder / CAMPAIGN, *dict.fromkeys(entry.file for entry in entries)):
        try:
            digest.update(hashlib.sha256(bytes_of(file)).digest())
        except OSError:  # which whoever reads it says better
            continue
    return digest.hexdigest()


def _made_run(entry: Entry) -> Run:
    """Returns what a recording of the campaign was asked to be; neither for a measured drive."""
    if entry.measured_drive:
        return Run()
    if entry.forced and entry.omega is not None:
        return Run(omega=entry.omega)
    drive = metadata_of(entry.file).get("drive")
    release = drive.get("release") if isinstance(drive, dict) else None
    return Run(release=float(release) if isinstance(release, int | float) else 0.0)
