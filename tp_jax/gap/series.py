"""Curves and residuals of the held-out recordings, thinned, for a report to draw."""

import numpy as np

from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.gap.calibration import Floor
from tp_jax.gap.held_out import HeldOut
from tp_jax.results.diagnosis import HeldOutRun, Numbers, RecordingUsed, Series, Start

THINNED = 600  # points of a curve in the result


def recordings(
    setting: PreparedCampaign, before: dict[int, np.ndarray], after: dict[int, np.ndarray]
) -> tuple[RecordingUsed, ...]:
    """The recordings, and the estimated states at the start of those held out."""
    return tuple(
        RecordingUsed(
            label=r.label,
            file=r.name,
            sha256=r.sha256,
            held_out=r.held_out,
            forced=r.forced,
            omega=r.omega,
            begin=float(r.t[0]),
            duration=r.duration,
            samples=r.n,
            started=r.started,
            start=Start.read(
                {
                    state: starts[i].tolist()
                    for state, starts in (("before", before), ("after", after))
                    if i in starts
                }
            ),
        )
        for i, r in enumerate(setting.recordings)
    )


def _thin(n: int) -> np.ndarray:
    return np.unique(np.linspace(0, n - 1, min(n, THINNED)).round().astype(int))


def curves(
    setting: PreparedCampaign,
    before: dict[int, np.ndarray] | None,
    after: dict[int, np.ndarray] | None,
) -> tuple[HeldOutRun, ...]:
    """Free runs of the held-out recordings beside what was measured [rad]."""
    begun = before or {}  # what is held out has free runs
    return tuple(
        _run(setting, i, setting.prepared[i].y, begun[i], None if after is None else after[i])
        for i in setting.held_out
    )


def residuals(
    setting: PreparedCampaign, before: HeldOut, after: HeldOut | None, least: Floor
) -> tuple[HeldOutRun, ...]:
    """Windowed residuals of the held-out recordings in units of the floor.

    NaN in a window through which the model could not be integrated.
    """
    windows = before.fit.problem.windows

    def of(held: HeldOut, i: int) -> np.ndarray:
        lin = held.fit.linearisation
        r = np.where(lin.complete[:, None], lin.samples, np.nan)
        mine = np.flatnonzero(windows.recording == i)
        found = np.concatenate([r[j, : 2 * windows.count[j]].reshape(-1, 2) for j in mine])
        for c, (sd, x) in enumerate(
            zip(setting.prepared[i].sigma, least.total.values(), strict=False)
        ):
            found[:, c] *= sd / x if x else 1.0
        return found

    return tuple(
        _run(setting, i, None, of(before, i), None if after is None else of(after, i))
        for i in setting.held_out
    )


def _run(
    setting: PreparedCampaign,
    i: int,
    measured: np.ndarray | None,
    before: np.ndarray,
    after: np.ndarray | None,
) -> HeldOutRun:
    """A recording's readings (n, 2), or residuals where nothing is measured, thinned."""
    p = setting.prepared[i]
    keep = _thin(p.t.size)

    def numbers(of: np.ndarray | None, c: int) -> Numbers | None:
        return None if of is None else tuple(of[keep, c].tolist())

    def series(c: int) -> Series | None:
        if not p.channels[c]:
            return None
        given = {} if measured is None else {"measured": numbers(measured, c)}
        return Series(**given, before=numbers(before, c), after=numbers(after, c))

    t = tuple(p.t[keep].tolist())
    return HeldOutRun(setting.recordings[i].label, t, series(0), series(1))
