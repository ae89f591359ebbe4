"""scripts/events: hard friction from event to event, which smooth friction tends to."""

import numpy as np
import pytest

import tp_jax as tp
from scripts._bench import problem
from scripts._bench.peers import ours
from scripts._events import __main__ as study
from scripts._events import lanes

TS = problem.times(1.0)
ROWS = np.stack(
    [
        problem.bench(),
        problem.bench(Ts1=3.0),  # the rider mostly sticks
        problem.bench(Ts1=0.3, M1=0.3),
        problem.bench(Tst=-2.0),  # a friction that falls with speed
    ]
)
STARTS = np.array([[0.0] * 4, [0.1, 0.0, 3.0, -2.0], [0.2, 0.1, -2.0, 2.0], [0.1, 0.0, 1.0, 1.0]])


def smooth(eps: float) -> np.ndarray:
    found = tp.sweep(ours._models(ROWS, eps), TS, STARTS, tolerance=1e-9, velocities=False)
    return np.stack([found.phi1, found.phi2], axis=-1)


def test_smooth_friction_tends_to_hard_friction():
    found = lanes.run(ROWS, TS, 1e-10, STARTS)
    assert found.complete.all()
    assert (found.events > 5).all()
    off = [np.abs(smooth(eps) - found.angles).max(axis=(1, 2)) for eps in (1e3, 5e4, 1e7)]
    assert (off[0] > 5.0 * off[1]).all()
    assert (off[1] > 5.0 * off[2]).all()
    # what falls with speed magnifies every difference
    assert (off[2] < (1e-5, 1e-5, 1e-5, 2e-4)).all()


def test_the_tolerance_is_kept():
    sharp = lanes.run(ROWS, TS, 1e-11, STARTS).angles
    assert np.abs(lanes.run(ROWS, TS, 1e-6, STARTS).angles - sharp).max() < 2e-5
    # steps and lanes are nothing that the motion knows of
    other = lanes.run(ROWS, TS, 1e-11, STARTS, width=2, per_step=1).angles
    assert np.abs(other - sharp).max() < 1e-8


def test_derivatives_are_those_of_the_motion():
    found = lanes.run(ROWS, TS, 1e-10, STARTS, derivatives=True)
    assert found.derivatives is not None
    for j, name in enumerate(problem.DIRECTIONS):
        step = 1e-6 * (ROWS[:, j] if j < len(problem.VARIED) else np.ones(len(ROWS)))
        ends = []
        for way in (1.0, -1.0):
            rows, starts = ROWS.copy(), STARTS.copy()
            if j < len(problem.VARIED):
                rows[:, j] += way * step
            else:
                starts[:, j - len(problem.VARIED)] += way * step
            ends.append(lanes.run(rows, TS, 1e-12, starts).angles)
        change = (ends[0] - ends[1]) / (2.0 * step[:, None, None])
        size = np.abs(change).max(axis=(1, 2)) + 1e-3
        # samples within a step's change of an event see some of either side
        off = np.quantile(np.abs(change - found.derivatives[..., j]), 0.99, axis=(1, 2)) / size
        assert (off < 1e-3).all(), name


def test_what_is_stuck_stays_and_has_no_derivative():
    row = problem.bench(A=0.05)  # the spring never reaches what the bearing holds
    found = lanes.run(row[None], TS, 1e-8, derivatives=True)
    assert found.derivatives is not None
    assert not found.angles.any()
    assert not found.derivatives[..., : len(problem.VARIED)].any()
    assert found.events[0] == 0


@pytest.mark.slow
def test_a_table(monkeypatch, capsys):
    cases = study.cases
    monkeypatch.setattr(study, "cases", lambda duration, many: cases(duration, many)[:1])
    assert study.main(["--quick"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[2].startswith("| bench, one run | ")
    assert lines[3].startswith("| – its 14 derivatives | ")
    assert "mrad" in lines[7]
    assert lines[9].startswith("Of 2 draws from all bounds 0 were given up")
