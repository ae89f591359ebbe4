"""Free runs: from the state at the start of a recording to its end, never corrected."""

from collections.abc import Sequence

import numpy as np

from tp_jax.estimation.from_readings import fit_from_readings
from tp_jax.estimation.layout import Values
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.estimation.problem import Problem, room
from tp_jax.estimation.windows import Windows
from tp_jax.recordings import stretches


def start_state(
    setting: PreparedCampaign, values: Values, recording: int, horizon: float
) -> np.ndarray:
    """State at the start of a recording (4,), estimated on its first window only.

    The numbers are the recording's too: of one held out, as `held_out.evaluate` leaves them.
    The window ends at a gap, unless that leaves fewer than eight samples.
    """
    p = setting.prepared[recording]
    count = int(np.searchsorted(p.t, p.t[0] + horizon, side="right"))
    count = min(count, stretches(p.t)[0].stop)
    windows = Windows(np.array([recording]), np.array([0]), np.array([max(count, 8)]), horizon)
    capacity = room(windows, setting.capacity)
    problem = Problem(
        setting.layout,
        setting.prepared,
        windows,
        capacity,
        setting.fixed["B1"],
        programs=setting.programs,
    )
    return fit_from_readings(problem, values, eps=setting.eps).states[0]


def free_runs(
    setting: PreparedCampaign, values: Values, recordings: Sequence[int], states: np.ndarray
) -> list[np.ndarray]:
    """Predicted readings of recordings (n, 2) [rad] from their start states (r, 4) alone.

    What cannot be integrated is NaN.
    """
    return setting.problem(setting.horizons[0]).follow(values, recordings, states)
