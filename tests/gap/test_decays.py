"""Decays of a column alone; scripts/nulls has those in which a weak drag is hidden, too."""

import functools
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import tp_jax as tp
from tests.noisy import moving_average
from tp_jax.recordings import Campaign, Recording

RATE, DURATION, SIGMA = 60.0, 25.0, 2.3e-3
RELEASES = (1.0, 0.8, 0.6)  # rad


@functools.cache
def decay(drag: float, release: float) -> tuple[np.ndarray, np.ndarray]:
    """Times and angles of a swing with a linear spring, per unit of inertia."""

    def rates(t, y):
        friction = 0.02 * np.tanh(y[1] / 1e-3)
        return [y[1], -36.0 * y[0] - 0.02 * y[1] - drag * abs(y[1]) * y[1] - friction]

    t = np.arange(round(DURATION * RATE) + 1) / RATE
    run = solve_ivp(
        rates, (0.0, DURATION), [release, 0.0], t_eval=t, rtol=1e-9, atol=1e-10, method="LSODA"
    )
    return t, run.y[0]


def campaign(drag: float, seed: int) -> Campaign:
    """Three decays, as a video shows them: neighbouring errors are negatively correlated."""
    rng = np.random.default_rng(seed)
    recordings = []
    for i, release in enumerate(RELEASES):
        t, y = decay(drag, release)
        y = y + SIGMA * moving_average(rng, (t.size, 1), -0.4)[:, 0]
        name = f"decay-{i}.csv"
        recordings.append(
            Recording(
                name=name,
                label=name,
                file=Path(name),
                t=t,
                phi1=y,
                phi2=None,
                drive=None,
                forced=False,
                omega=None,
                span=None,
                start=None,
                repeat=None,
                held_out=False,
                sha256="",
            )
        )
    return Campaign(
        name="sail",
        model="single",
        B1=None,
        B2=None,
        k=None,
        sample_rate=None,
        recordings=tuple(recordings),
        folder=Path(),
    )


@pytest.mark.slow
def test_a_viscous_decay_is_followed_to_its_end():
    """The free run of the baseline comes down to the noise: its windows grow until then."""
    d = tp.diagnose(campaign(0.0, 1)).to_dict()
    assert d["verdict"] == "no_gap"
    assert d["gap"]["before"]["free_run"] < 1.1 * SIGMA
