"""The baseline fit of a campaign: start from the data, then a schedule of window lengths.

Short windows are convex enough to be found from afar; long ones say more. The horizon follows the
sampling and the period of the motion, the smoothing of the friction is raised as the windows
grow.
"""

import dataclasses
import functools
import logging
from collections.abc import Callable, Collection, Sequence
from typing import Any

import numpy as np

from tp_jax.effects import AnyLaw, Effect, catalogue
from tp_jax.estimation.fitted import Fit, GaussianPrior
from tp_jax.estimation.layout import Layout, Unknown, Values, order
from tp_jax.estimation.least_squares import fit as fit_together
from tp_jax.estimation.period import horizons_of, typical_period
from tp_jax.estimation.problem import Problem, room, sample_capacity
from tp_jax.estimation.program_choice import Programs
from tp_jax.estimation.start import start_from_data
from tp_jax.estimation.variable_projection import fit
from tp_jax.estimation.window_states import of_windows
from tp_jax.estimation.windows import Prepared, cut, prepare
from tp_jax.model.parameters import BASE, BY_NAME, DEFAULT_EPS, PAPER_EPS, SHARPEST_EPS
from tp_jax.model.pendulum import NEWTON_REACTION, PRINTED_REACTION
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

log = logging.getLogger(__name__)

Progress = Callable[[str, float | None], None]

#: Tst and T0 are nearly confounded with Ts1; without any slip T0 is free. A wide prior on log T0
#: keeps the steps finite and is reported as unidentifiable where it decides.
T0_PRIOR = (np.log(5.0), 2.0)

LEAST_NOISE = 1e-6  # rad; of a channel that is constant, so that nothing is divided by zero
PATIENCE = 100  # steps of a fit: far from a rider that hardly moves, some rigs need more than 50
POOR = 2.0  # chi2/dof of a fit to the shortest windows that is looked for another way too

MOST_WINDOWS = 160
"""Windows of a fit that only leads to the next one: more say no better which valley it is."""

DIED = 3.0
"""T0 times a slip speed from which the contact's exponential has died out there, to a twentieth.
Where it has at nine tenths of all speeds, no derivative leads back to where it had not."""

RIDER = ("B2", "Tv", "Ts1", "Tst", "T0")


@dataclasses.dataclass(frozen=True)
class PreparedCampaign:
    """A campaign made ready: layout, prepared recordings, noise, horizons, what is unknown.

    Attributes:
        campaign, recordings: all of them, held-out ones included.
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
        supports: middle and half width of what the recordings visit of each law's argument, by the
            law's family; empty until laws are asked for (`gap.visited`).
        ruled_out: ids of effects and laws that are not asked about.
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
    supports: dict[str, tuple[float, float]] = dataclasses.field(default_factory=dict)
    ruled_out: frozenset[str] = frozenset()

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
        return any(_sine(r) for r in self.recordings)

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
            spec = BY_NAME[name]
            centre = float(spec.to_coordinate(value))
            priors.append(GaussianPrior(Unknown(name), centre, sd / spec.slope(value)))
        if "T0" in names:
            priors.append(GaussianPrior(Unknown("T0"), *T0_PRIOR))
        return tuple(priors)


def _sine(r: Recording) -> bool:
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
    recordings = tuple(map(thinned, campaign.recordings, blocks))
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


def initial_values(setting: PreparedCampaign) -> Values:
    """All numbers before any fit: the data's own start, and what is given."""
    campaign = setting.campaign
    B1 = setting.fixed["B1"]
    fitted = [setting.recordings[i] for i in setting.fitted]
    given = {n: v for n, v in setting.fixed.items() if n in ("B2", "k")}
    sigma = {"phi1": setting.sigma[0], "phi2": setting.sigma[1]}
    start = start_from_data(fitted, sigma, setting.widths[setting.fitted], B1, given)
    if setting.model == "paper":  # the printed model with all of the column's numbers doubled
        for name in ("B2", "Tv", "Ts1", "Tst"):
            if name in start and name not in given:
                start[name] *= 0.5
    middle, rate = (list(each) for each in zip(*(r.drift for r in setting.recordings), strict=True))
    clocks = [r.start for r in setting.recordings]
    if all(c is not None for c in clocks):  # drifts run on the campaign's clock
        begin = min(c + r.t[0] for c, r in zip(clocks, setting.recordings, strict=True))
        end = max(c + r.t[-1] for c, r in zip(clocks, setting.recordings, strict=True))
        middle = [0.5 * (begin + end) - c for c in clocks]
        rate = [1.0 / (end - begin)] * len(clocks)
    paper = setting.model == "paper"
    values: dict[str, object] = {
        "B1": B1,
        "B2": B1,
        "k": B1,
        "T0": 1.0,
        "eps1": setting.eps,
        "eps2": setting.eps,
        "reaction": PRINTED_REACTION if paper else NEWTON_REACTION,
        "omega": [r.omega if _sine(r) else 0.0 for r in setting.recordings],
        "running": [float(_sine(r)) for r in setting.recordings],
        "metered": [float(r.measured_drive) for r in setting.recordings],
        "drift_middle": middle,
        "drift_rate": rate,
    }
    out = Values.build(setting.layout, len(campaign.recordings), {**values, **start})
    return out.replace(setting.fixed)


def fit_over_schedule(
    setting: PreparedCampaign,
    values: Values,
    unknowns: Sequence[Unknown],
    *,
    horizons: Sequence[float] | None = None,
    which: Sequence[int] | None = None,
    progress: Progress | None = None,
    max_iterations: int = PATIENCE,
) -> Fit:
    """Fits on a schedule of window lengths, with the friction's smoothing raised on the way."""
    horizons = setting.horizons if horizons is None else horizons
    schedule = np.minimum(
        np.geomspace(PAPER_EPS, setting.eps, max(len(horizons) - 1, 1)), setting.eps
    )
    result: Fit | None = None
    for i, horizon in enumerate(horizons):
        if progress is not None:
            stage = f"fitting windows: {horizon:.2g} s, {i + 1} of {len(horizons)}"
            progress(stage, i / len(horizons))
        problem = setting.problem(horizon, which)
        last = i + 1 == len(horizons)
        if not last:
            problem = of_windows(problem, few_of(problem.windows.n))
        eps = setting.eps if last else float(schedule[i])
        values = values.replace({"eps1": eps, "eps2": eps})
        states = None if result is None else warm_start_states(result, problem)
        how: dict[str, Any] = dict(
            bounds=setting.bounds,
            priors=[a for a in setting.priors() if a.unknown in unknowns],
            max_iterations=max_iterations,
            relative=1e-3 if i + 1 < len(horizons) else 1e-7,
        )
        result = fit(problem, values, unknowns, states, **how)
        if i == 0 and result.chi2_dof > POOR:
            # The short windows choose the valley. Steps of states and unknowns together are shorter
            # and go another way.
            other = fit_together(problem, values, unknowns, states, **how)
            result = min(result, other, key=lambda found: found.cost)
        if last:
            result = _slower(setting, result, how)
        values = result.values
        log.info("windows of %.3g s: chi2/dof %.4g, %s", horizon, result.chi2_dof, result.message)
    assert result is not None
    return result


def few_of(count: int, most: int = MOST_WINDOWS) -> np.ndarray:
    """Places of at most so many of `count` windows, spread over all, at no regular distance.

    Every second one of windows of a quarter of a period would always see the same of the swing.
    """
    if count <= most:
        return np.arange(count)
    golden = 0.5 * (np.sqrt(5.0) - 1.0)
    within = (np.arange(most) * golden) % 1.0
    edges = np.arange(most + 1) * count // most
    return edges[:-1] + (within * np.diff(edges)).astype(int)


def _slower(setting: PreparedCampaign, found: Fit, how: dict[str, Any]) -> Fit:
    """The better of two fits: as found, and sought where its contact rises at speeds that are met.

    Only where that found rises at speeds too small to be met.
    """
    if Unknown("T0") not in found.unknowns or not np.isfinite(found.cost):
        return found
    speed = np.concatenate([np.abs(setting.prepared[i].path[:, 3]) for i in setting.fitted])
    if not (found.values.get("Tst") and speed.any()):  # then T0 is of no matter
        return found
    speed = speed[speed > 0.1 * speed.max()]  # of a rider that sticks it is noise
    if found.values.get("T0") * np.quantile(speed, 0.1) < DIED:
        return found
    start = found.values.replace({"T0": 1.0 / float(np.median(speed))})
    # held there first, or the others, which are those of another contact, would drive it back
    others = [u for u in found.unknowns if u.name != "T0"]
    priors = [a for a in how["priors"] if a.unknown.name != "T0"]
    held = fit(found.problem, start, others, found.states, **{**how, "priors": priors})
    other = fit(found.problem, held.values, found.unknowns, held.states, **how)
    log.info(
        "T0 %.3g instead of %.3g: chi2/dof %.5g, was %.5g",
        other.values.get("T0"),
        found.values.get("T0"),
        other.chi2_dof,
        found.chi2_dof,
    )
    return min(found, other, key=lambda one: one.cost)


def warm_start_states(before: Fit, problem: Problem) -> np.ndarray:
    """Window states for a new cut, read off the trajectories of the last one."""
    states = problem.initial_states(before.values)
    old, new = before.problem.windows, problem.windows
    for i in range(new.n):
        same = np.flatnonzero(
            (old.recording == new.recording[i])
            & (old.first <= new.first[i])
            & (new.first[i] < old.first + old.count)
        )
        if same.size:
            j = same[0]
            states[i] = before.linearisation.states[j, new.first[i] - old.first[j], :4]
    return states
