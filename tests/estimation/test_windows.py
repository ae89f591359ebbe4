"""Windows: every sample in one, none across a gap."""

import dataclasses

import numpy as np
import pytest

from tests.rigs import bench_problem, choose, lossy, prepared, synthetic_campaign, synthetic_values
from tp_jax.estimation.free_runs import FreeRuns
from tp_jax.estimation.prepared_campaign import prepare_campaign
from tp_jax.estimation.windows import Prepared, cut, prepare
from tp_jax.recordings import stretches

RATE = 250.0
SIGMA = np.array([1e-3, 1e-3])


def at(t: np.ndarray) -> Prepared:
    """A recording at these times, of which nothing else matters."""
    both = np.array([True, True])
    return Prepared(
        t, np.zeros((t.size, 2)), both, np.zeros((t.size, 4)), np.ones((t.size, 4)), None
    )


@pytest.mark.parametrize("n", [50, 501, 1000])
@pytest.mark.parametrize("horizon", [0.048, 0.1, 0.3, 10.0])
def test_uniform_times_are_cut_in_equal_counts(n, horizon):
    windows = cut([at(np.arange(n) / RATE)], horizon)
    pieces = max(1, round(n / round(horizon * RATE)))
    edges = np.linspace(0, n, pieces + 1).round().astype(int)
    np.testing.assert_array_equal(windows.first, edges[:-1])
    np.testing.assert_array_equal(windows.count, np.diff(edges))
    assert windows.n == pieces


@pytest.mark.parametrize("horizon", [0.05, 0.1, 0.3, 10.0])
def test_no_window_reaches_across_a_gap(horizon):
    campaign = synthetic_campaign()
    runs = [
        lossy(r, i, (0.4, 0.8), (0.9, 0.95), (1.3, 2.9)) for i, r in enumerate(campaign.recordings)
    ]
    data = [prepare(r, SIGMA, 11) for r in runs]
    windows = cut(data, horizon)
    for r, run in enumerate(runs):
        mine = choose(windows, np.flatnonzero(windows.recording == r))
        # in order, each sample once
        np.testing.assert_array_equal(mine.first, np.append(0, np.cumsum(mine.count)[:-1]))
        assert mine.count.sum() == run.n
        assert {p.start for p in stretches(run.t)} <= set(mine.first)
        for first, count in zip(mine.first, mine.count, strict=True):
            t = run.t[first : first + count]
            assert np.diff(t).max(initial=0.0) <= 2.01 / RATE
            assert np.ptp(t) < 1.6 * max(horizon, 8 / RATE)


def test_short_stretches_are_short_windows():
    t = np.arange(300) / RATE
    windows = cut([at(t[[*range(100), *range(150, 155), 200, *range(250, 300)]])], 0.2)
    np.testing.assert_array_equal(windows.count, [50, 50, 5, 1, 50])


def test_readings_are_not_smoothed_across_a_gap():
    run = lossy(synthetic_campaign().recordings[1], 0, (1.3, 1.7))
    whole = prepare(run, SIGMA, 11)
    begin = 0
    for part in stretches(run.t):
        alone = prepare(run.cut(run.t[part.start], run.t[part.stop - 1]), SIGMA, 11)
        assert part.start == begin
        np.testing.assert_array_equal(whole.smooth[part], alone.smooth)
        np.testing.assert_array_equal(whole.smooth_sd[part], alone.smooth_sd)
        begin = part.stop


def test_rates_of_an_island_are_like_the_others():
    run = lossy(synthetic_campaign().recordings[1], 0, (1.3, 1.498), (1.51, 1.7))
    data = prepare(run, SIGMA, 11)
    island = slice(*np.searchsorted(run.t, [1.4, 1.6]))
    assert 1 <= island.stop - island.start <= 3
    np.testing.assert_array_equal(data.smooth[island, :2], data.y[island])
    np.testing.assert_array_equal(data.smooth[island, 2:], 0.0)
    typical = 3.0 * np.sqrt(np.mean(data.smooth[:, 2:] ** 2, axis=0))
    np.testing.assert_allclose(data.smooth_sd[island.start, 2:], typical, rtol=0.05)


def test_an_island_says_nothing_and_costs_nothing():
    problem = bench_problem(0.2)
    before = problem.degrees_of_freedom(0)
    full = prepared(0)
    keep = np.delete(np.arange(full.t.size), [*range(200, 220), *range(221, 240)])
    island = Prepared(
        full.t[keep], full.y[keep], full.channels, full.smooth[keep], full.smooth_sd[keep], None
    )
    both = (island, problem.prepared[1])
    after = dataclasses.replace(problem, prepared=both, windows=cut(both, 0.2))
    assert 1 in after.windows.count
    windows = after.windows.n - problem.windows.n - 1  # the island's takes nothing
    assert after.degrees_of_freedom(0) == before - 2 * 40 - 4 * windows


def test_free_runs_go_on_through_gaps():
    campaign = synthetic_campaign(noise=1e-4)
    runs = [lossy(r, i, (0.5, 0.9), (1.3, 1.7)) for i, r in enumerate(campaign.recordings)]
    setting = prepare_campaign(dataclasses.replace(campaign, recordings=tuple(runs)), effects=())
    objective = FreeRuns(setting)
    assert all(r.t[0] == 0.0 for r in runs)
    objective.groups[0].states[0] = [1.2, 0.0, 0.0, 0.0]  # as it was, not as the readings tell
    y = objective([synthetic_values(setting)])
    assert y == pytest.approx(1e-8, rel=0.1)  # the noise, and nothing where there is no sample
