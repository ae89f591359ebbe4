"""Choice of the next run: the one that tells the first cause from its rivals best.

Everything here is a pure function of plain numbers. The forecasts come from `tp_jax.gap.forecast`.
The evidence of a run is additive, so that a run is worth the expected difference of the log
evidences of the first cause and a rival on it: Lindley (1956), Ann. Math. Statist. 27, 986-1005;
Box and Hill (1967), Technometrics 9, 57-71.
"""

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np

from tp_jax.gap.policy import POLICY, ExplorePolicy
from tp_jax.results.diagnosis import DiagnosisRecord

NOTHING = "nothing"
"""The rival of a cause that is not accepted yet: the model as it is, without any effect."""

CAUSE, NONE_LEFT, TIED, RUNS = "cause", "nothing_left", "indistinguishable", "runs"
"""Reasons to stop: the cause is known; nothing is left to explain; no allowed run tells the rivals
apart; as many runs as were asked for are made."""


@dataclasses.dataclass(frozen=True)
class Run:
    """A run of the rig: driven or released, not both.

    Attributes:
        omega: frequency of the drive [rad/s], or
        release: angle from which the column is let go, the motor at neutral [rad].
    """

    omega: float | None = None
    release: float | None = None

    def __str__(self) -> str:
        if self.omega is not None:
            return f"drive at {self.omega:.4g} rad/s"
        return f"decay from {self.release or 0.0:.3g} rad"


@dataclasses.dataclass(frozen=True)
class Limits:
    """Limits that the rig and its owner set.

    Attributes:
        angle: largest predicted angle of column and rider [rad]; None: any.
        omega: lowest and highest frequency of the drive [rad/s]; None: about the resonance.
        drives, releases: whether runs of this kind can be made.
    """

    angle: float | None = None
    omega: tuple[float, float] | None = None
    drives: bool = True
    releases: bool = True


@dataclasses.dataclass(frozen=True)
class Forecast:
    """Expected outcome of a run.

    Attributes:
        run: the run.
        largest: angle of column or rider under any of the models that can be followed [rad]; None:
            the fitted baseline cannot.
        log_evidence: id of a rival -> expected difference of the log evidences of the first cause
            and of it on this run [nat], everything else fitted anew.
    """

    run: Run
    largest: float | None
    log_evidence: Mapping[str, float] = dataclasses.field(default_factory=dict)


@dataclasses.dataclass(frozen=True)
class Finding:
    """Finding of a diagnosis about the next run.

    Attributes:
        verdict: explained, no_gap or unknown.
        causes: accepted ones in order, id and probability.
        first: id of the most probable cause, accepted or not; None: there is no candidate.
        probability: of it.
        rivals: id -> probability of what it is to be told from, most probable first.
        forecasts: of the runs that may come next.
    """

    verdict: str
    causes: tuple[tuple[str, float], ...] = ()
    first: str | None = None
    probability: float = 0.0
    rivals: Mapping[str, float] = dataclasses.field(default_factory=dict)
    forecasts: tuple[Forecast, ...] = ()


@dataclasses.dataclass(frozen=True)
class Next:
    """The run to record, with its forecast."""

    forecast: Forecast


@dataclasses.dataclass(frozen=True)
class Stop:
    """The end: a reason (`CAUSE`, `NONE_LEFT`, `TIED` or `RUNS`), and a sentence about it."""

    reason: Literal["cause", "nothing_left", "indistinguishable", "runs"]
    sentence: str


def finding_of(diagnosis: DiagnosisRecord, policy: ExplorePolicy = POLICY.explore) -> Finding:
    """Reads from a diagnosis the first cause and its rivals, without forecasts.

    An effect that these data cannot tell from the first (`confused_with`) is a rival however small
    its probability.
    """
    causes = tuple((c.effect, c.probability or 0.0) for c in diagnosis.accepted)
    accepted = {id for id, _ in causes}
    likely = {c.effect: c.probability or 0.0 for c in diagnosis.candidates if c.applicable}
    verdict = diagnosis.verdict or "unknown"
    if verdict == "no_gap" or not (causes or likely):
        return Finding(verdict, causes)
    first = causes[0][0] if causes else max(likely, key=lambda id: likely[id])
    probability = causes[0][1] if causes else likely[first]
    if not causes and probability < policy.rival:
        return Finding(verdict)
    alike = diagnosis.tied_with(first)
    others = {
        id: p
        for id, p in likely.items()
        if id != first and id not in accepted and (p >= policy.rival or id in alike)
    }
    if not causes:
        others[NOTHING] = max(1.0 - sum(likely.values()), policy.rival)
    ranked = sorted(others.items(), key=lambda each: -each[1])[: policy.rivals]
    return Finding(verdict, causes, first, probability, dict(ranked))


def runs_to_compare(
    natural: float, limits: Limits, policy: ExplorePolicy = POLICY.explore
) -> list[Run]:
    """The runs that are compared, drives before decays.

    Args:
        natural: frequency of both bodies together [rad/s], about which to drive where the limits
            do not say.
        limits: of the rig. Its angle is left to `choose`, so that a wider one can be advised.
    """
    runs = []
    if limits.drives:
        low, high = limits.omega or (policy.slowest * natural, policy.fastest * natural)
        grid = np.linspace(low, high, policy.frequencies)
        runs += [
            Run(omega=float(f"{w:.4g}")) if low < w < high else Run(omega=float(w))
            for w in dict.fromkeys(grid.tolist())
        ]
    if limits.releases:
        grid = np.linspace(policy.least_release, policy.largest_release, policy.releases)
        angles = {round(float(x), 3) for x in grid}
        if limits.angle is not None:
            angles.add(float(f"{_first_release(limits, policy):.4g}"))
        runs += [Run(release=x) for x in sorted(angles)]
    return runs


def first_run(limits: Limits, policy: ExplorePolicy = POLICY.explore) -> Run:
    """The run that nothing can be predicted for yet.

    A column that is let go swings no further than where it was let go, and a rider that slips no
    further than twice that against the column: half of a limit keeps it. Where nobody can let it go
    it is driven at the lowest frequency.

    Raises:
        ValueError: neither can be done.
    """
    if limits.releases:
        return Run(release=_first_release(limits, policy))
    if limits.drives and limits.omega is not None:
        return Run(omega=limits.omega[0])
    raise ValueError("A first run needs a release, or a range of frequencies.")


def _first_release(limits: Limits, policy: ExplorePolicy) -> float:
    if limits.angle is None:
        return policy.first_release
    return min(policy.first_release, 0.5 * policy.margin * limits.angle)


def next_run(
    finding: Finding,
    limits: Limits,
    made: Sequence[Run],
    most: int,
    duration: float,
    policy: ExplorePolicy = POLICY.explore,
) -> Next | Stop:
    """The run to record next, or the reason why there is none.

    Args:
        finding: of the diagnosis of all runs so far.
        limits: of the rig. made: the runs so far. most: runs at most. duration: of a run [s].
    """
    sure = [(id, p) for id, p in finding.causes[:1] if p >= policy.probability]
    if sure:
        id, p = sure[0]
        more = "; something beside it is left" if finding.verdict == "unknown" else ""
        return Stop(CAUSE, f"The cause is {id}, with probability {shown(p)}{more}.")
    if finding.verdict == "no_gap" and len(made) >= min(policy.nothing, most):
        return Stop(NONE_LEFT, "The recordings show nothing that the model does not explain.")
    if len(made) >= most:
        runs = f"{most} run{'s' if most != 1 else ''}"
        return Stop(RUNS, f"The cause is not known after {runs}; ask for more with --runs.")
    open_ = [f for f in finding.forecasts if allowed(f, limits, policy)]
    if not open_:
        return Stop(TIED, _nothing_allowed(finding, limits))
    # one that tells a single rival apart comes before one that hints at several
    best = max(open_, key=lambda f: (_tells(f, policy), worth(f, finding.rivals, policy)))
    if _tells(best, policy):
        return Next(best)
    if not finding.rivals or len(made) < policy.survey:
        return Next(_farthest(open_, made, policy))
    # evidence adds up: what no run tells alone, those that are left to make may tell together
    if _together(open_, most - len(made)) >= policy.log_evidence:
        return Next(best)
    return Stop(TIED, _needed(finding, best, limits, duration, policy))


def allowed(forecast: Forecast, limits: Limits, policy: ExplorePolicy = POLICY.explore) -> bool:
    """True where a run stays within the limits, as far as it can be predicted."""
    if forecast.largest is None or not _possible(forecast.run, limits):
        return False
    return limits.angle is None or forecast.largest <= policy.margin * limits.angle


def _possible(run: Run, limits: Limits) -> bool:
    """True where a run of this kind can be made, whatever angle it reaches."""
    if run.omega is None:
        return limits.releases
    low, high = limits.omega or (-np.inf, np.inf)
    return limits.drives and low <= run.omega <= high


def _rounded_up(x: float) -> float:
    """Rounds up to two digits, so that the advice, followed, is enough."""
    unit = 10.0 ** (np.floor(np.log10(x)) - 1)
    return float(f"{np.ceil(x / unit - 1e-9) * unit:.2g}")


def worth(
    forecast: Forecast, rivals: Mapping[str, float], policy: ExplorePolicy = POLICY.explore
) -> float:
    """Expected log evidence against the rivals [nat], weighted by their probabilities.

    Against each rival it counts up to `enough`. A trifle of the rest is added, which decides
    between runs that tell all of them apart.
    """
    total = sum(rivals.values())
    if not total:
        return 0.0
    told = {id: max(forecast.log_evidence.get(id, 0.0), 0.0) for id in rivals}
    counted = sum(p * min(told[id], policy.enough) for id, p in rivals.items()) / total
    return counted + 1e-6 * sum(p * told[id] for id, p in rivals.items()) / total


def _largest(forecast: Forecast) -> float:
    return max(forecast.log_evidence.values(), default=0.0)


def _together(forecasts: Sequence[Forecast], runs: int) -> float:
    """Expected log evidence against any one rival of the best runs, so many of them [nat]."""
    rivals = {id for f in forecasts for id in f.log_evidence}
    return max(
        (
            sum(sorted((f.log_evidence.get(id, 0.0) for f in forecasts), reverse=True)[:runs])
            for id in rivals
        ),
        default=0.0,
    )


def _tells(forecast: Forecast, policy: ExplorePolicy) -> bool:
    """True where a run is expected to tell the first cause from any rival."""
    return _largest(forecast) >= policy.log_evidence


def _farthest(
    forecasts: Sequence[Forecast], made: Sequence[Run], policy: ExplorePolicy
) -> Forecast:
    """The run that is least like those made: the kind that is missing, then the widest gap."""
    decays = [f for f in forecasts if f.run.omega is None]
    drives = [f for f in forecasts if f.run.omega is not None]
    driven = [run.omega for run in made if run.omega is not None]
    released = [run.release for run in made if run.release is not None]
    if decays and not released:
        return min(decays, key=lambda f: abs((f.run.release or 0.0) - policy.first_release))
    if drives and not driven:
        return drives[len(drives) // 2]
    if drives:
        return max(drives, key=lambda f: min(abs((f.run.omega or 0.0) - w) for w in driven))
    return max(decays, key=lambda f: min(abs((f.run.release or 0.0) - x) for x in released))


def _nothing_allowed(finding: Finding, limits: Limits) -> str:
    smallest = min(
        (f for f in finding.forecasts if f.largest is not None),
        default=None,
        key=lambda f: f.largest or 0.0,
    )
    if smallest is None or limits.angle is None:
        return "No further run can be predicted; see whether the recordings are right."
    return (
        f"Every further run would exceed the limit of {limits.angle:g} rad; the gentlest, a "
        f"{smallest.run}, is predicted to reach {smallest.largest:.3g} rad."
    )


def _needed(
    finding: Finding,
    best: Forecast,
    limits: Limits,
    duration: float,
    policy: ExplorePolicy,
) -> str:
    """Says that no allowed run tells the rivals apart, and what would."""
    names = " and ".join(["the model as it is" if r == NOTHING else r for r in finding.rivals])
    said = f"No run within the limits can tell {finding.first} from {names}"
    beyond = [
        f
        for f in finding.forecasts
        if f.largest is not None and _tells(f, policy) and _possible(f.run, limits)
    ]
    if beyond and limits.angle is not None:
        gentlest = min(beyond, key=lambda f: f.largest or 0.0)
        at_least = (gentlest.largest or 0.0) / policy.margin
        return f"{said}; with --limit {_rounded_up(at_least):g} a {gentlest.run} could."
    told = _largest(best)
    times = policy.log_evidence / told if told > 0.0 else np.inf
    if times <= policy.longer:
        longer = np.ceil(times * duration)
        return f"{said}; a {best.run} of {longer:g} s could (--duration {longer:g})."
    return (
        f"{said}; a measurement of another kind is needed, such as one of the part by itself "
        "(`tp-jax effects` says of each effect what to do about it)."
    )


def shown(p: float) -> str:
    """Returns a probability for people: none is one."""
    return f"{p:.3g}" if p < 0.999 else "above 0.999"
