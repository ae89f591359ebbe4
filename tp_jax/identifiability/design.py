"""Experiments on paper: how a rig is driven, where its motion begins, when it is read."""

import dataclasses
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import ArrayLike

from tp_jax.estimation.assemble import drive_for, fit_record, pendulum
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.model import presets
from tp_jax.model.parameters import DEFAULT_EPS
from tp_jax.model.pendulum import NEWTON_REACTION, AbstractTorsionPendulum

#: The paper's unknowns (11), and what else of a pendulum is a number, by their places in it.
PLACES = {
    "B1": "B1",
    "B2": "B2",
    "k": "spring.k",
    "A": "drive.A",
    "c1": "bearing.c1",
    "M1": "bearing.M1",
    "Tv": "contact.Tv",
    "Ts1": "contact.Ts1",
    "Ts2": "contact.Ts2",
    "Tst": "contact.Tst",
    "T0": "contact.T0",
    "gain": "drive.gain",
    "reaction": "reaction",
}

UNKNOWNS = ("B1", "B2", "k", "A", "c1", "M1", "Tv", "Ts1", "Ts2", "Tst", "T0")
"""The eleven unknowns of (11), in the order of Listing 1 where they stand there."""

OF_THE_RIDER = ("B2", "Tv", "Ts1", "Ts2", "Tst", "T0")

SAMPLES = 201
"""Times at which a design is read: enough for every turn of a motion of some twenty periods."""

SPAN = 100.0
"""Longest design, in first windows of the estimation (a quarter of a period each)."""


@dataclasses.dataclass(frozen=True)
class Design:
    """One experiment.

    Attributes:
        label: of the recording it is like.
        ts: (n,) times [s].
        y0: (4,) phi1, phi2 [rad], omega1, omega2 [rad/s] at the first of them.
        build: numbers by the paper's names -> the pendulum in this experiment. Each number ()
            or (N,): many pendulums at once.
        unknowns: names of what the motion may depend on.
        sigma: (2,) noise of the two angles [rad], infinite where one is not measured.
    """

    label: str
    ts: np.ndarray
    y0: np.ndarray
    build: Callable[[Mapping[str, ArrayLike]], AbstractTorsionPendulum]
    unknowns: tuple[str, ...]
    sigma: np.ndarray

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the measured angles."""
        measured = zip(("phi1", "phi2"), self.sigma, strict=True)
        return tuple(name for name, sd in measured if np.isfinite(sd))


def sine_design(
    omega: float,
    ts: ArrayLike,
    *,
    release: float = 0.0,
    label: str = "",
    noise: float = 1e-3,
    eps: float = DEFAULT_EPS,
    reaction: float = NEWTON_REACTION,
) -> Design:
    """A sine drive, or a release from an angle with the motor at rest.

    Args:
        omega: frequency of the drive [rad/s]; 0: the motor is at rest.
        ts: (n,) times [s].
        release: phi1 at the first of them [rad].
        label: of the design.
        noise: standard deviation of either angle [rad].
        eps: smoothing of the friction [s].
        reaction: factor of M_T in (16a), unless `build` is given another.
    """

    def build(p: Mapping[str, ArrayLike]) -> AbstractTorsionPendulum:
        return presets.double_pendulum(**{"reaction": reaction, "eps": eps, "omega": omega, **p})

    y0 = np.array([release, 0.0, 0.0, 0.0])
    name = label or (f"{omega:g} rad/s" if omega else f"release at {release:g} rad")
    return Design(
        name, np.asarray(ts, float), y0, build, (*UNKNOWNS, "reaction"), np.full(2, noise)
    )


def designs_of(setting: PreparedCampaign, fit: Fit) -> tuple[Design, ...]:
    """The fitted recordings of a campaign as experiments, from their estimated first states."""
    labels = [r.label for r in setting.recordings]
    record = fit_record(fit.values, (), labels)
    windows = fit.problem.windows
    designs = []
    for i in setting.fitted:
        r = setting.recordings[i]
        first = int(np.flatnonzero(windows.recording == i)[0])
        span = min(r.duration, SPAN * setting.horizons[0])
        sigma = np.where(setting.prepared[i].channels, setting.levels[i], np.inf)
        designs.append(
            Design(
                r.label,
                np.linspace(r.t[0], r.t[0] + span, SAMPLES),
                np.asarray(fit.states[first], float),
                _builder(record, setting, i),
                _unknowns(setting, i),
                sigma,
            )
        )
    return tuple(designs)


def _unknowns(setting: PreparedCampaign, recording: int) -> tuple[str, ...]:
    names = [n for n in UNKNOWNS if setting.rider or n not in OF_THE_RIDER]
    if setting.recordings[recording].measured_drive:
        names = ["gain" if n == "A" else n for n in names]
    return tuple(names)


def _builder(record: Mapping, setting: PreparedCampaign, recording: int) -> Callable:
    r = setting.recordings[recording]
    sine = r.forced and not r.measured_drive

    def build(p: Mapping[str, ArrayLike]) -> AbstractTorsionPendulum:
        nuisances = {**record["nuisances"], **{n: v for n, v in p.items() if n == "gain"}}
        numbers = {**record["parameters"], **{n: v for n, v in p.items() if n in UNKNOWNS}}
        mine = {**record, "parameters": numbers, "nuisances": nuisances}
        mine["reaction"] = p.get("reaction", record["reaction"])
        drive = drive_for(mine, omega=r.omega if sine else None, t=r.t, reading=r.drive)
        return pendulum(mine, drive, r.label)

    return build
