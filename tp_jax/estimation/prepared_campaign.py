"""A campaign made ready for fits: its noise, its layout of numbers, window lengths and priors."""

import dataclasses
import functools
from collections.abc import Collection, Sequence

import numpy as np

from tp_jax.effects import AnyLaw, Effect, catalogue
from tp_jax.estimation.layout import Layout, Unknown, order
from tp_jax.estimation.period import horizons_of, typical_period
from tp_jax.estimation.priors import GaussianPrior
from tp_jax.estimation.problem import Problem, room, sample_capacity
from tp_jax.estimation.program_choice import Programs
from tp_jax.estimation.windows import Prepared, cut, prepare
from tp_jax.model.parameters import BASE, BY_NAME, DEFAULT_EPS, PAPER_EPS, SHARPEST_EPS
from tp_jax.recordings import (
    Campaign,
    Colour,
    Recording,
    block_length,
    noise_colour,
    noise_levels,
    same_rate,
    thinned,
)
from tp_jax.recordings.drive_noise import PeriodicDrive, without_drive_noise
from tp_jax.recordings.noise import is_coarse

#: Tst and T0 are nearly confounded with Ts1; without any slip T0 is free. A wide prior on log T0
#: keeps the steps finite and is reported as unidentifiable where it decides.
T0_PRIOR = (np.log(5.0), 2.0)

LEAST_NOISE = 1e-6  # rad; of a channel that is constant, so that nothing is divided by zero

RIDER = ("B2", "Tv", "Ts1", "Tst", "T0")


@dataclasses.dataclass(frozen=True)
class PreparedCampaign:
    """A campaign made ready: layout, prepared recordings, noise, horizons, what is unknown.

    Attributes:
        campaign, recordings: all of them, held-out ones included; recordings may be thinned, and
            have no noise of a measured drive that is periodic (`drive_noise`).
        layout: with the whole catalogue's slots.
        prepared: one per recording.
        levels: (r, 2) sd of the noise of both channels in every recording [rad].
        data_noise: levels, and colours of both channels in every recording, as the data alone say.
        horizons: window lengths [s], growing.
        capacity: samples of a block.
        fixed: values the user or the campaign gave.
        prior_values: those from the campaign (name: value, sd).
        model: "newton" or "paper".
        bounds: by name, where the user gave them.
        widths: (r,) samples of the window that smooths a recording.
        period: of the column's motion, typically [s].
        blocks: (r,) samples of which each of a recording's is the mean (`recordings.thinning`).
        coarse: whether each is one of them instead, since steps of the readings hide their noise.
        supports: middle and half width of what the recordings visit of each law's argument, by the
            law's family; empty until laws are asked for (`gap.visited`).
        ruled_out: ids of effects and laws that are not asked about.
        drives: noisy measured ones that the angles put right (`drive_errors`), by recording.
    """

    campaign: Campaign
    recordings: tuple[Recording, ...]
    layout: Layout
    prepared: tuple[Prepared, ...]
    levels: np.ndarray
    data_noise: tuple[np.ndarray, tuple[tuple[Colour, Colour], ...]]
    horizons: tuple[float, ...]
    capacity: int
    fixed: dict[str, float]
    prior_values: dict[str, tuple[float, float]]
    model: str
    bounds: dict[str, tuple[float, float]]
    widths: np.ndarray
    period: float
    blocks: tuple[int, ...] = ()
    coarse: bool = False
    supports: dict[str, tuple[float, float]] = dataclasses.field(default_factory=dict)
    ruled_out: frozenset[str] = frozenset()
    drives: dict[int, PeriodicDrive] = dataclasses.field(default_factory=dict)

    @functools.cached_property
    def programs(self) -> Programs:
        """Shared by all problems of the campaign."""
        return Programs(self.layout)

    @property
    def fitted(self) -> list[int]:
        """Recordings that may be fitted."""
        return [i for i, r in enumerate(self.recordings) if not r.held_out]

    @property
    def held_out(self) -> list[int]:
        """Recordings that are only predicted."""
        return [i for i, r in enumerate(self.recordings) if r.held_out]

    @property
    def noise(self) -> dict[str, float]:
        """Noise by channel [rad]: the median over the fitted recordings."""
        names = ("phi1", "phi2") if self.rider else ("phi1",)
        return dict(zip(names, np.median(self.levels[self.fitted], axis=0).tolist(), strict=False))

    @property
    def held_out_noise(self) -> dict[str, float]:
        """Noise by channel of the held-out recordings [rad]: root mean square over samples."""
        which = self.held_out or self.fitted
        samples = [self.prepared[i].t.size for i in which]
        square = np.average(self.levels[which] ** 2, axis=0, weights=samples)
        return {n: float(np.sqrt(x)) for n, x in zip(self.noise, square, strict=False)}

    @property
    def sigma(self) -> np.ndarray:
        """(2,) the same as an array, 1 where a channel is missing."""
        return np.array([self.noise["phi1"], self.noise.get("phi2", 1.0)])

    @property
    def rider(self) -> bool:
        """True where there is a second body."""
        return self.campaign.model == "double"

    @property
    def sine(self) -> bool:
        """True where any drive is a commanded sine."""
        return any(is_sine(r) for r in self.recordings)

    @property
    def eps(self) -> float:
        """Smoothing of the friction [s] up to which a search raises it."""
        return PAPER_EPS if self.model == "paper" else DEFAULT_EPS

    @property
    def sharpest(self) -> float:
        """Smoothing of the friction [s] of what is found; see `sharpen`."""
        return PAPER_EPS if self.model == "paper" else SHARPEST_EPS

    def problem(self, horizon: float, which: Sequence[int] | None = None) -> Problem:
        """Some recordings (the fitted ones if None) in windows of one length."""
        which = self.fitted if which is None else which
        windows = cut([self.prepared[i] for i in which], horizon)
        windows = dataclasses.replace(windows, recording=np.array(which)[windows.recording])
        # Windows longer than planned for take a larger block, and with it another compilation.
        capacity = room(windows, self.capacity)
        return Problem(
            self.layout,
            self.prepared,
            windows,
            capacity,
            self.fixed["B1"],
            programs=self.programs,
        )

    def unknowns(self) -> tuple[Unknown, ...]:
        """The baseline's unknowns and the nuisances that go with it."""
        absent = (() if self.rider else RIDER) + (() if self.sine else ("A",))
        names = [p.name for p in BASE if p.free and p.name not in absent]
        if self.sine:
            names += ["phase", "zero1"]
        if any(r.measured_drive for r in self.recordings):
            names += ["gain", "level"]
        # The rest position of a measured drive is its level; that of a motor at rest is the zero.
        if not self.sine and not all(r.measured_drive for r in self.recordings):
            names += ["zero1"]
        return tuple(Unknown(n) for n in names if n not in self.fixed)

    def priors(self) -> tuple[GaussianPrior, ...]:
        """Priors of the baseline's unknowns."""
        priors = []
        names = [u.name for u in self.unknowns()]
        for name, (value, sd) in self.prior_values.items():
            spec = BY_NAME[name].scaled(self.fixed["B1"])
            mean = float(spec.to_coordinate(value))
            priors.append(GaussianPrior(Unknown(name), mean, sd / spec.slope(value)))
        if "T0" in names:
            priors.append(GaussianPrior(Unknown("T0"), *T0_PRIOR))
        return tuple(priors)


def is_sine(r: Recording) -> bool:
    """True where a run is driven by a sine that was commanded."""
    return r.forced and r.omega is not None and not r.measured_drive


def prepare_campaign(
    campaign: Campaign,
    *,
    model: str = "newton",
    fix: dict[str, float] | None = None,
    bound: dict[str, tuple[float, float]] | None = None,
    effects: Sequence[Effect] | None = None,
    without: Collection[str] = (),
) -> PreparedCampaign:
    """Reads noise, sampling and period off the recordings and lays out the estimation.

    `without` are ids of effects and laws that are not asked about.
    """
    period = typical_period([r for r in campaign.recordings if not r.held_out])
    blocks = tuple(block_length(r, period) for r in campaign.recordings)
    coarse = any(n > 1 and is_coarse(r) for r, n in zip(campaign.recordings, blocks, strict=True))
    recordings = tuple(
        thinned(without_drive_noise(r), n, coarse=coarse)
        for r, n in zip(campaign.recordings, blocks, strict=True)
    )
    fitted = [r for r in recordings if not r.held_out]
    colours = _colours(recordings, period)
    levels = noise_levels(recordings, colours)
    levels = np.where(levels > 0.0, levels, LEAST_NOISE)
    if effects is None:
        effects = [*catalogue().values(), AnyLaw()]
        if campaign.model == "single":
            effects = [e for e in effects if not e.about_rider]
    layout = Layout(campaign.model, tuple(sorted(effects, key=order)))
    own = np.array([np.median(np.diff(r.t)) for r in recordings])
    step = float(np.median(own))
    widths = np.clip(np.round(period / 10.0 / own), 7, 25).astype(int) | 1
    prepared = tuple(
        prepare(r, own, int(w), colour)
        for r, own, w, colour in zip(recordings, levels, widths, colours, strict=True)
    )
    # what is shorter than a window is one window
    horizons = horizons_of(period, step, float(np.median([r.duration for r in fitted])))
    counts = [round(horizons[-1] / step) + 2]
    fixed = {"B1": campaign.B1 or 1.0}
    prior_values = {}
    for name in ("B2", "k"):
        known = getattr(campaign, name)
        if known is not None and known.sd is None:
            fixed[name] = known.value
        elif known is not None:
            prior_values[name] = (known.value, known.sd)
    fixed |= fix or {}
    return PreparedCampaign(
        campaign,
        recordings,
        layout,
        prepared,
        levels,
        (levels, tuple(colours)),
        horizons,
        sample_capacity(counts),
        fixed,
        prior_values,
        model,
        dict(bound or {}),
        widths,
        period,
        blocks,
        coarse,
        ruled_out=frozenset(without),
    )


def _colours(recordings: Sequence[Recording], period: float) -> list[tuple[Colour, Colour]]:
    """Colour of both channels' noise in each recording; those of one sampling rate have one."""
    out = [(Colour(), Colour())] * len(recordings)
    for group in same_rate(recordings):
        fitted = [recordings[i] for i in group if not recordings[i].held_out]
        pair = (
            noise_colour(fitted, "phi1", period),
            noise_colour(fitted, "phi2", period),
        )
        for i in group:
            out[i] = pair
    return out
