"""All checks of a campaign at once."""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tp_jax.checks import angle_units, drive, held_readings, rider, sampling, starts
from tp_jax.checks.finding import LEVELS, Finding
from tp_jax.checks.policy import CheckPolicy
from tp_jax.errors import InputError
from tp_jax.recordings import Campaign
from tp_jax.recordings.campaign import load_what_can_be


@dataclass(frozen=True)
class Checked:
    """Result of `check`.

    Attributes:
        campaign: of the recordings that can be read; None where there are none.
        findings: what is wrong, then what is doubtful, then what was mended in reading.
        shares: label of a forced run -> share of phi1's variance at its omega and two harmonics.
    """

    campaign: Campaign | None
    findings: tuple[Finding, ...]
    shares: Mapping[str, float]

    @property
    def wrong(self) -> tuple[Finding, ...]:
        """Findings that are refused."""
        return tuple(each for each in self.findings if each.level == "wrong")

    @property
    def doubtful(self) -> tuple[Finding, ...]:
        """Findings that are reported, while the recordings are used all the same."""
        return tuple(each for each in self.findings if each.level == "doubtful")

    def refuse(self) -> None:
        """Raises the first of what is wrong.

        Raises:
            InputError: in one sentence, with the mend.
        """
        if self.wrong:
            more = len(self.wrong) - 1
            others = f" ({more} more: `tp-jax check` tells all.)" if more else ""
            raise InputError(self.wrong[0].sentence + others)

    def to_dict(self) -> dict[str, Any]:
        """Returns it as `tp-jax check --json` writes it."""
        return {
            "schema": "tp-jax/check/1",
            "campaign": None if self.campaign is None else self.campaign.name,
            "good": not self.wrong,
            "findings": [
                {
                    "kind": each.kind,
                    "level": each.level,
                    "recordings": list(each.recordings),
                    "text": each.sentence,
                    "numbers": dict(each.numbers),
                }
                for each in self.findings
            ],
            "shares": dict(self.shares),
        }


def check(
    path: str | os.PathLike[str],
    *,
    omega: float | None = None,
    decay: bool = False,
    policy: CheckPolicy | None = None,
) -> Checked:
    """Reads a campaign and tells all that is wrong or doubtful about it, at once.

    Args:
        path, omega, decay: as of `load_campaign`.
        policy: what decides.
    """
    campaign, faults = load_what_can_be(path, omega=omega, decay=decay)
    unread = [Finding("file", "wrong", (), str(fault).rstrip(".?"), "") for fault in faults]
    if campaign is None:
        return Checked(None, tuple(unread), {})
    seen = examine(campaign, policy)
    return Checked(campaign, (*unread, *seen.findings), seen.shares)


def examine(campaign: Campaign, policy: CheckPolicy | None = None) -> Checked:
    """Looks at the recordings of a campaign that has been read."""
    policy = policy or CheckPolicy()
    recordings = campaign.recordings
    driven = drive.shares(recordings, policy.drive)
    found = drive.findings(driven, policy.drive)
    units = angle_units.look(recordings, driven, policy.drive, policy.rider, policy.unit)
    found += units.findings
    runs = [
        run
        for run in rider.dragged(driven, policy.drive, policy.rider)
        if run.recording.label not in units.labels
    ]
    found += rider.findings(runs, policy.rider)
    found += _same_angle(campaign)
    found += held_readings.findings(recordings)
    found += starts.findings(recordings, policy.start)
    for recording in recordings:
        found += sampling.findings(recording, policy.sampling, policy.clip)
    # of a motion in another unit nothing else can be said
    odd = {
        label
        for each in found
        if each.kind == "units" and each.level == "wrong"
        for label in each.recordings
    }
    found = [
        each
        for each in found
        if each.level == "wrong"
        or each.kind not in ("units", "sampling", "clock")
        or not odd.issuperset(each.recordings)
    ]
    found += [Finding("read", "mended", (), note, "") for note in campaign.notes]
    found.sort(key=lambda each: LEVELS.index(each.level))
    return Checked(campaign, tuple(found), {d.recording.label: d.share for d in driven})


def _same_angle(campaign: Campaign) -> list[Finding]:
    """phi2 read from phi1's column."""
    labels = tuple(
        r.label
        for r in campaign.recordings
        if r.phi2 is not None and np.array_equal(r.phi1, r.phi2)
    )
    if not labels:
        return []
    return [
        Finding(
            "rider",
            "wrong",
            labels,
            "phi1 and phi2 are the same numbers",
            "name the right column for each under [format.columns]",
        )
    ]
