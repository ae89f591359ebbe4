"""Runs that begin from rest at times of their own, where the drive has no phase in common."""

from collections.abc import Sequence

import numpy as np

from tp_jax.checks.finding import Finding
from tp_jax.checks.policy import StartPolicy
from tp_jax.recordings import Recording, noise_level


def findings(recordings: Sequence[Recording], policy: StartPolicy) -> list[Finding]:
    """One finding for all runs whose times begin elsewhere than those of the others.

    The drive is taken to have one phase at the time 0 of every file. It has, where the time begins
    with the motor; where it is that of a board since it was switched on, each run has another.
    """
    begins = [
        (each, float(each.omega * each.t[0]))
        for each in recordings
        if each.forced and each.omega is not None and each.span is None
    ]
    phases = np.exp(1j * np.array([phase for _, phase in begins]))
    if len(begins) < 2 or np.ptp(np.abs(np.angle(phases / phases[0]))) < policy.phase:
        return []
    late = [run for run, phase in begins if abs(phase) > policy.phase and _from_rest(run, policy)]
    if not late:
        return []
    first = late[0]
    return [
        Finding(
            "clock",
            "doubtful",
            tuple(run.label for run in late),
            f"times begin at {first.t[0]:.4g} s where the run begins from rest, so that the drive "
            "has another phase at time 0 than in other runs",
            "write wrap = true for t under [format.columns], which counts from the first row, "
            "unless the motor's sine ran on between the runs",
            {"begins": float(first.t[0])},
        )
    ]


def _from_rest(run: Recording, policy: StartPolicy) -> bool:
    """True if the column does not yet move in the first part of a period."""
    part = run.t - run.t[0] < policy.part * 2.0 * np.pi / (run.omega or 1.0)
    if part.sum() < policy.samples:
        return False
    still = float(np.abs(run.phi1[part] - np.median(run.phi1[part])).max())
    rest = max(policy.noise * noise_level(run.t, run.phi1), policy.way * float(np.std(run.phi1)))
    return still < rest
