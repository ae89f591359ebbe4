"""A measured drive that is recorded late: its reading, its derivative, the rig that has it."""

import dataclasses

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from tests.reference import BENCH, reference
from tests.rigs import CAPACITY, prepared
from tp_jax.effects import Applied, catalogue, get
from tp_jax.estimation.assemble import drive_for, pendulum
from tp_jax.estimation.layout import Layout, Values
from tp_jax.estimation.prepared_campaign import prepare_campaign
from tp_jax.estimation.problem import Problem
from tp_jax.estimation.program import TRACES
from tp_jax.estimation.windows import cut, read_later
from tp_jax.gap.applicability import why_not
from tp_jax.model import presets
from tp_jax.model.drive import PiecewiseCubicDrive
from tp_jax.recordings import load_campaign
from tp_jax.rig import VirtualRig, make_campaign
from tp_jax.simulation import simulate

DELAY, GAIN = 6e-3, 0.5
TS = np.arange(501) / 250.0
OMEGA = 13.09
IDS = ("drive_delay", "spring_hysteresis")


def recorded(t, delay: float = 0.0):
    """What is read at t of the bench's drive."""
    return BENCH["A"] / GAIN * np.sin(OMEGA * (np.asarray(t) - delay))


@pytest.mark.parametrize("late", [-0.05, 0.002, 0.05])
@pytest.mark.parametrize("samples", [17, 40, 120])  # in a period
def test_read_later_is_the_curve_later(late, samples):
    t = np.arange(0.0, 3.0, 2.0 * np.pi / OMEGA / samples)
    pieces = CubicSpline(t, np.sin(OMEGA * t)).c.T
    drive = PiecewiseCubicDrive(1.0, 0.0, t, read_later(t, pieces, late).T)
    dense = np.linspace(0.3, 2.7, 1001)
    error = np.abs(np.asarray(drive.angle(dense, None)) - np.sin(OMEGA * (dense + late))).max()
    # whatever the delay: see the module of the effect
    assert error < (2.0 * np.pi / samples) ** 4 / 180.0
    assert error < 1e-4 or samples < 17


def test_beyond_its_ends_a_drive_goes_on_straight():
    t = np.linspace(0.0, 1.0, 101)
    line = CubicSpline(t, 3.0 * t).c.T
    np.testing.assert_allclose(read_later(t, line, 0.05)[:, 3], 3.0 * (t[:-1] + 0.05), atol=1e-12)
    drive = PiecewiseCubicDrive(2.0, 0.0, t, line.T)
    np.testing.assert_allclose(drive.later(t, 0.05), 2.0 * 3.0 * 0.05, atol=1e-12)
    assert read_later(t, line, 0.0) is line


def test_a_run_with_a_late_record_is_the_run():
    drive = PiecewiseCubicDrive(GAIN, 0.0, TS, CubicSpline(TS, recorded(TS, DELAY)).c)
    term = Applied(get("drive_delay"), {"a": np.float64(DELAY)})
    model = dataclasses.replace(presets.double_pendulum(**BENCH, terms=(term,)), drive=drive)
    bare = dataclasses.replace(model, terms=())
    inside = TS[: -round(DELAY * 250.0) - 1]  # there the drive is known
    expected = reference(BENCH, inside)[:, 0]
    found = np.asarray(simulate(model, inside).phi1)
    # until the first sample the record says nothing, and a straight line is no sine
    assert np.abs(found - expected).max() < 1e-4
    assert np.abs(np.asarray(simulate(bare, inside).phi1) - expected).max() > 1e-2


def test_a_sine_is_commanded_and_never_late():
    term = Applied(get("drive_delay"), {"a": np.float64(0.05)})
    late, bare = (presets.double_pendulum(**BENCH, terms=x) for x in ((term,), ()))
    y = (0.1, 0.2, 0.3, 0.4)
    np.testing.assert_array_equal(late.derivative(0.3, y), bare.derivative(0.3, y))


@pytest.fixture(scope="module")
def problem() -> Problem:
    """The bench's first recording, its drive recorded late."""
    data = prepared(0)
    pieces = CubicSpline(data.t, recorded(data.t, DELAY)).c.T
    data = (dataclasses.replace(data, pieces=pieces),)
    layout = Layout("double", tuple(get(id) for id in IDS))
    windows = cut(data, 0.25)
    return Problem(layout, data, windows, CAPACITY, BENCH["B1"])


def values(problem: Problem, **changes) -> Values:
    same = {n: v for n, v in BENCH.items() if n not in ("eps", "omega", "A")}
    given = dict(eps1=BENCH["eps"], eps2=BENCH["eps"], metered=1.0, gain=GAIN)
    return Values.build(problem.layout, 1, same | given | changes)


def windowed(problem: Problem, slots=(), **changes):
    at = values(problem, **changes)
    return problem.linearise(at, problem.initial_states(at), slots)


def test_windows_read_the_drive_later(problem):
    # the last window ends where the drive is not known any more
    late, right = (
        np.abs(windowed(problem, **{"drive_delay.a": a}).r[:-1]).max() for a in (0.0, DELAY)
    )
    assert late > 5e-3
    assert right < 2e-5


# beside an effect that remembers the drive, too
@pytest.mark.parametrize(("a", "beside"), [(0.0, 0.0), (DELAY, 0.1)])
def test_derivative(problem, a, beside):
    own = {"spring_hysteresis.a": beside}
    found = windowed(problem, ("drive_delay.a",), **{"drive_delay.a": a}, **own)
    h = 1e-6
    ends = [windowed(problem, **{"drive_delay.a": a + x}, **own).r for x in (h, -h)]
    expected = (ends[0] - ends[1])[1:-1, :-4] / (2.0 * h)
    error = np.linalg.norm(found.slots_jac[1:-1, :-4, 0] - expected) / np.linalg.norm(expected)
    # what such an effect remembers at the start of a window is no unknown
    assert error < (0.01 if not beside else 0.2)


def test_a_delay_compiles_nothing(problem):
    windowed(problem, ("drive_delay.a",))
    before = len(TRACES)
    windowed(problem, ("drive_delay.a",), **{"drive_delay.a": -0.03})
    assert len(TRACES) == before


def test_a_prediction_reads_it_later():
    record = dict(
        kind="double",
        eps=BENCH["eps"],
        reaction=1.0,
        parameters={n: v for n, v in BENCH.items() if n not in ("eps", "omega")},
        nuisances=dict(phase=0.0, gain=GAIN, level=0.0, zero1=0.0, zero2={"run": 0.0}),
        effects={"drive_delay": {"a": DELAY}},
    )
    drive = drive_for(record, t=TS, reading=recorded(TS, DELAY))
    inside = TS[:490]
    found = np.asarray(simulate(pendulum(record, drive), inside).phi1)
    assert np.abs(found - reference(BENCH, inside)[:, 0]).max() < 1e-4


def test_the_rig_records_it_late():
    rig = VirtualRig(effects={"drive_delay": 0.02})
    rig.start(omega=OMEGA)
    assert rig.read_drive(0.01) == 0.0
    assert rig.read_drive(1.0) == pytest.approx(0.18 * np.sin(OMEGA * 0.98), abs=1e-12)
    # and moves as if it had not
    np.testing.assert_array_equal(rig.run(TS, omega=OMEGA), VirtualRig().run(TS, omega=OMEGA))


def test_a_rig_with_it_records_its_drive(tmp_path):
    key = make_campaign(
        tmp_path / "late", effects={"drive_delay": 0.01}, runs=3, duration=2.0, noise=0.0, bits=32
    )
    campaign = load_campaign(tmp_path / "late")
    assert [r.measured_drive for r in campaign.recordings] == [False, True, True]
    run, omega = campaign.recordings[1], key["runs"][1]["omega"]
    expected = np.where(run.t > 0.01, 0.18 * np.sin(omega * (run.t - 0.01)), 0.0)
    np.testing.assert_allclose(run.drive, expected, atol=1e-8)
    make_campaign(tmp_path / "plain", runs=3, duration=2.0)
    for name, applies in (("late", True), ("plain", False)):
        setting = prepare_campaign(load_campaign(tmp_path / name))
        assert (why_not(get("drive_delay"), setting) is None) == applies
    assert "measured drive" in why_not(catalogue()["drive_delay"], setting)
