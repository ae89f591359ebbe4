"""Gradients on short windows that grow: the package's own estimation, from the paper's start."""

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from scripts._paper.nelder_mead import Searched
from scripts._paper.objective import ORDER, Objective
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.prepared_campaign import PreparedCampaign, prepare_campaign
from tp_jax.estimation.problem import Problem
from tp_jax.estimation.schedule import fit_over_schedule
from tp_jax.estimation.start import initial_values
from tp_jax.recordings import Campaign, Recording

LADDER = (0.25, 0.6, 1.5, 4.0)
"""Window lengths [s] before the whole recording: short ones for a start that is far off."""


def campaign_of(name: str, B1: float, objectives: Sequence[Objective]) -> Campaign:
    """Forced recordings as a campaign; B1 is what is believed of the column [kg m^2]."""
    runs = [
        Recording(
            name=f"{name}-{i + 1}",
            label=f"{name}-{i + 1}",
            file=Path(f"{name}-{i + 1}"),
            t=o.ts,
            phi1=o.phi1,
            phi2=o.phi2,
            drive=None,
            forced=True,
            omega=o.omega,
            span=None,
            start=None,
            repeat=None,
            held_out=False,
            sha256="",
        )
        for i, o in enumerate(objectives)
    ]
    return Campaign(
        name=name,
        model="double",
        B1=B1,
        B2=None,
        k=None,
        sample_rate=None,
        recordings=tuple(runs),
        folder=Path(),
    )


def search(
    objectives: Sequence[Objective], B1: float, start=None, judged_by: Objective | None = None
) -> tuple[Searched, Fit, PreparedCampaign]:
    """Windows that grow; the printed model.

    Args:
        objectives: the recordings.
        B1: held there [kg m^2].
        start: (11,) numbers; the data's own start if None.
        judged_by: what y is reported for; the first recording if None.
    """
    setting = prepare_campaign(campaign_of("paper", B1, objectives), model="paper", effects=())
    values, schedule = initial_values(setting), None
    if start is not None:
        shortest = min(float(o.ts[-1] - o.ts[0]) for o in objectives)
        schedule = (*(h for h in LADDER if h < 0.5 * shortest), shortest)
        names = dict(zip(ORDER, np.asarray(start, float).tolist(), strict=True))
        given = {n: v for n, v in names.items() if n not in ("B1", "Ts2")}
        values = values.replace(given | {"phase": 0.0, "zero1": 0.0})
    begin = time.perf_counter()
    with counted() as calls:
        fit = fit_over_schedule(setting, values, setting.unknowns(), horizons=schedule)
    seconds = time.perf_counter() - begin
    x = np.array([fit.values.get(n) for n in ORDER])
    y = (judged_by or objectives[0]).of_x(x)
    return Searched(x, y, len(calls), seconds, [], fit.message), fit, setting


@contextmanager
def counted() -> Iterator[list[int]]:
    """Counts linearisations: each is one look at all samples, with derivatives."""
    calls: list[int] = []
    own = Problem.linearise

    def linearise(self, *args, **more):
        calls.append(1)
        return own(self, *args, **more)

    Problem.linearise = linearise  # type: ignore[method-assign]
    try:
        yield calls
    finally:
        Problem.linearise = own  # type: ignore[method-assign]
