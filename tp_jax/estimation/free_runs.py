"""The paper's objective (17) for many sets of numbers at once: all their runs in one batch."""

import dataclasses
from collections.abc import Sequence

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from tp_jax.estimation.layout import Layout, Values
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.estimation.windows import Prepared
from tp_jax.model.arrays import AnyArray
from tp_jax.model.drive import LanewiseDrive, PiecewiseCubicDrive
from tp_jax.recordings import Recording
from tp_jax.recordings.gaps import stretches
from tp_jax.simulation.batch import lanes
from tp_jax.simulation.control import Control
from tp_jax.simulation.runs import integrate
from tp_jax.simulation.solve import samples_per_step

AT_REST = 4.0  # standard errors: a first reading within them of rest is rest
SLOW = 0.05  # of the largest rate: a decay that begins no faster was let go
FIRST_SAMPLES = 4  # that the state at the beginning is read from
POWERS = (0, 2)  # of time, in a motion that begins at rest
SWEPT = 1e-6  # error of an angle in a step [rad], as in a sweep
SIDE_BY_SIDE = 16  # lanes: of a search's hundred runs the longest end alone, in few lanes
STEPS = 60  # per sample: numbers that need more are too stiff to be anybody's


class FreeRuns(eqx.Module):
    """y = mean over recordings of (17): half the sum of the channels' mean squared errors.

    With one channel, its mean square. Forced runs start from rest and decays from where they were
    let go, unless the first readings say otherwise. Traceable, and the same program for campaigns
    whose recordings are as many and as long.
    """

    layout: Layout = eqx.field(static=True)
    groups: tuple["Group", ...]

    def __init__(self, setting: PreparedCampaign):
        self.layout = Layout(setting.campaign.model, ())
        self.groups = tuple(Group(setting, which) for which in _groups(setting))

    def __call__(self, many: Sequence[Values]) -> Float[np.ndarray, " m"]:
        """y [rad^2] of many sets of numbers; infinite where a run could not be integrated."""
        slots = len(self.layout.parameters)
        return np.asarray(_of_tables(self, np.stack([v.table[:slots] for v in many])))

    def of_tables(
        self, tables: Float[AnyArray, "m P R"], active: Int[Array, ""] | int | None = None
    ) -> Float[Array, " m"]:
        """The same of tables of numbers, of which the first `active` count (all if None)."""
        total = sum(self._of_group(tables, group, active) for group in self.groups)
        total = total / sum(len(group.which) for group in self.groups)
        return jnp.where(jnp.isfinite(total), total, jnp.inf)

    def _of_group(self, tables: AnyArray, group: "Group", active: Array | int | None) -> Array:
        """Sum of (17) over recordings with the same times."""
        size, index = len(group.which), self.layout.index
        p = tables[:, :, np.array(group.which)].transpose(1, 0, 2).reshape(tables.shape[1], -1)
        zeros = jnp.stack([p[index[n]] for n in ("zero1", "zero2")])
        start = jnp.tile(group.states.T, (1, len(tables))).at[:2].add(-zeros)

        def field(t, y, q):
            model = self.layout.model(q)
            if group.pieces is not None:
                lanewise = model.drive
                assert isinstance(lanewise, LanewiseDrive)
                drive = PiecewiseCubicDrive(lanewise.gain, lanewise.level, group.ts, group.pieces)
                model = dataclasses.replace(model, drive=drive)
            return model.derivative(t, y)

        run = integrate(
            field,
            tuple(p),
            start,
            group.ts,
            (p[index["eps1"]], p[index["eps2"]]),
            Control(angle=SWEPT),
            width=lanes(SIDE_BY_SIDE, p.shape[1]),
            per_step=samples_per_step(group.ts.size),
            velocities=False,
            max_steps=STEPS * group.ts.size,
            active=None if active is None else active * size,
        )
        y = (run.y + zeros.T[:, None]).reshape(-1, size, group.ts.size, 2)
        squares = ((y - group.readings) ** 2).mean(axis=2)[..., np.array(group.channels)]
        return squares.mean(axis=-1).sum(axis=1)


class Group(eqx.Module):
    """Recordings with the same times.

    which: places among the campaign's recordings; channels: those read; ts: (n,) s; states: (r, 4)
    to start from; readings: (r, n, 2) rad; pieces: (4, n - 1) of a measured drive, or None.
    """

    which: tuple[int, ...] = eqx.field(static=True)
    channels: tuple[int, ...] = eqx.field(static=True)
    ts: np.ndarray
    states: np.ndarray
    readings: np.ndarray
    pieces: np.ndarray | None

    def __init__(self, setting: PreparedCampaign, which: Sequence[int]):
        data = [setting.prepared[r] for r in which]
        self.which = tuple(which)
        self.channels = tuple(np.flatnonzero(data[0].channels).tolist())
        self.ts = data[0].t
        starts = [first_state(d, setting.recordings[r]) for d, r in zip(data, which, strict=True)]
        self.states = np.stack(starts)
        self.readings = np.stack([d.y for d in data])
        self.pieces = None if data[0].pieces is None else data[0].pieces.T


@eqx.filter_jit
def _of_tables(runs: FreeRuns, tables: AnyArray) -> Array:
    return runs.of_tables(tables)


def first_state(data: Prepared, recording: Recording) -> np.ndarray:
    """State (4,) at the first sample, as read: rest, unless the readings say otherwise.

    A decay is let go from anywhere, but from rest. Its angles are then those of the curve without
    a rate at its beginning: a polynomial that has one takes some of the bend for it, and so may
    have a small one by mistake.
    """
    state, sd = data.smooth[0].copy(), data.smooth_sd[0]
    slow = np.abs(state) < AT_REST * sd
    if recording.forced:
        return np.where(slow, 0.0, state)
    slow |= np.abs(state) < SLOW * np.abs(data.smooth).max(axis=0)
    part = stretches(data.t)[0]
    n = min(FIRST_SAMPLES, part.stop - part.start)
    since = data.t[:n] - data.t[0]
    for c in range(2):
        if slow[2 + c]:
            state[2 + c] = 0.0
            if n > len(POWERS):
                bent = (since / since[-1])[:, None] ** np.array(POWERS)
                state[c] = np.linalg.lstsq(bent, data.y[:n, c], rcond=None)[0][0]
    return state


def _groups(setting: PreparedCampaign) -> list[list[int]]:
    """Fitted recordings by their times; a measured drive is a group of its own."""
    groups: list[list[int]] = []
    for r in setting.fitted:
        data = setting.prepared[r]
        for group in groups:
            other = setting.prepared[group[0]]
            alone = data.pieces is not None or other.pieces is not None
            if not alone and np.array_equal(data.t, other.t):
                group.append(r)
                break
        else:
            groups.append([r])
    return groups
