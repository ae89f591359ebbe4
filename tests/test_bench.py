"""scripts/bench: its quick version, with the peers that need nothing beyond the package."""

import json
import math
import sys
import time

import numpy as np
import pytest

from tests import reference as plain
from tp_jax.model import presets

ALWAYS = "scipy_lsoda,scipy_radau,diffrax_tsit5"


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    """Runs it once, with caches of its own, and gives its JSON and its folder."""
    folder = tmp_path_factory.mktemp("bench")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(folder / "cache"))
        patch.setenv("NUMBA_CACHE_DIR", str(folder / "cache"))
        patch.setenv("TP_JAX_CACHE", "off")
        from scripts._bench.__main__ import main

        measures = "precision,single,sweep,sensitivities,stuck,robustness"
        out = folder / "out"
        code = main(["--quick", "--peers", ALWAYS, "--only", measures, "--out", str(out)])
    assert code == 0
    return json.loads((out / "bench.json").read_text(encoding="utf-8")), out


def numbers(value):
    """All numbers in a tree, and infinity for what could not be computed."""
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        return [number for entry in value for number in numbers(entry)]
    if value is None:
        return [math.inf]
    return [value] if isinstance(value, int | float) else []


@pytest.mark.slow
def test_everything_is_computed(result):
    found, _ = result
    names = ["tp-jax", "scipy-lsoda", "scipy-radau", "diffrax-tsit5"]
    assert found["peers"] == names
    assert np.isfinite(numbers(found["measures"])).all()
    for measure in ("single", "sweep"):
        assert [one["peer"] for one in found["measures"][measure]["results"]] == names


@pytest.mark.slow
def test_all_agree(result):
    found, _ = result
    measures = found["measures"]
    for measure in ("single", "sweep", "stuck"):
        for one in measures[measure]["results"]:
            assert one["error"] <= 10 * found["target"], (measure, one)
    assert measures["sweep"]["agreement"][0]["difference"] < 1e-8
    ours = measures["sensitivities"]["results"][0]
    assert ours["error"] < 0.1
    assert measures["robustness"]["results"][0]["lost"] == 0


@pytest.mark.slow
def test_rows_say_whether_a_bar_is_reached(result):
    found, _ = result
    held = [row for row in found["rows"] if row["bar"]]
    # those of the sweep are over peers that are not asked for here
    assert {row["measure"] for row in held} >= {"single", "sensitivities", "stuck", "robustness"}
    for row in held:
        assert row["reached"] == (row["margin"] <= 1.0)


def test_the_scipy_scripts_derivatives():
    pytest.importorskip("casadi")
    from scripts._bench import scipy_script
    from scripts._bench.problem import NAMES, SEARCHED, bench, times

    row = dict(zip(NAMES, bench(), strict=True))
    ts = times(0.4)
    runs = scipy_script.Runs(
        ts,
        np.zeros((2, ts.size, 2)),
        np.array([[0.5, 0.1, 0.0, 0.0], np.zeros(4)]),
        np.array([0.0, row["omega"]]),
        row["B1"],
        1e-3,
        1e3,
        1e-10,
    )
    x = np.log([row[name] for name in SEARCHED])
    found = scipy_script.jacobian(x, runs)
    for i, change in enumerate(1e-4 * np.eye(len(x))):
        ends = [scipy_script.residuals(x + s * change, runs) for s in (1.0, -1.0)]
        by_difference = (ends[0] - ends[1]) / 2e-4
        assert abs(found[:, i] - by_difference).max() < 0.02 * max(abs(found[:, i]).max(), 1.0)
    lower, upper = np.exp(x) / 10.0, np.exp(x) * 10.0
    drawn = scipy_script.starts(4, lower, upper, seed=0)
    assert (np.log(lower) <= drawn).all()
    assert (drawn <= np.log(upper)).all()


@pytest.mark.slow
def test_figures_are_drawn(result):
    _, folder = result
    drawn = {path.stem for path in folder.glob("*.png")}
    assert drawn == {"precision-eps-1000", "single-eps-1000", "sweep-eps-1000"}


def test_growth_is_measured_until_it_takes_too_long(monkeypatch):
    from scripts._bench.measures import growth
    from scripts._bench.measures.diagnosis import Took

    class Ours:
        name = "tp-jax"

    class Bench:
        ours, tell = Ours, print

    calls = []

    def diagnosed(folder, campaign=None):
        if campaign is None:
            return Took(1.0, 1.0, 0.1)
        n, rate = (float(x) for x in campaign.name.split("-at-"))
        calls.append((n, rate))
        return Took(1.0, n * rate / 100.0, 0.5)

    monkeypatch.setattr(growth, "diagnosed", diagnosed)
    monkeypatch.setattr(growth, "make_campaign", lambda *_, **__: None)
    found, rows = growth.measure(Bench())
    assert calls.count((6, 100.0)) == 2, "once to compile, and once to be timed"
    assert calls.count((6, 10_000.0)) == 1, "the first call took long enough to count"
    assert found["ratio"] == pytest.approx(100.0)
    assert list(found["recordings"]) == ["2", "5", "20", "50"]
    assert [row.value for row in rows if row.case == "200 recordings"] == [
        "skipped: about 2e+03 CPU s"
    ]


def test_a_diagnosis_is_timed_and_its_memory_taken(monkeypatch):
    from scripts._bench.measures import diagnosis
    from scripts._bench.problem import Scale

    class Ours:
        name = "tp-jax"

    class Bench:
        scale, ours, tell, against = Scale(pairs=2), Ours, print, None

    def command(out, campaign):  # takes a megabyte where there is a cache, or a hundred
        kept = out.parent / "kept"
        size = 1_000_000 if kept.exists() else 100_000_000
        kept.touch()
        return [sys.executable, "-c", f"bytearray({size})"]

    monkeypatch.setattr(diagnosis, "_command", command)
    numbers, rows = diagnosis.measure(Bench)
    cold, warm = numbers["cold"], numbers["warm"]
    assert 0.1 < cold["gigabytes"] < 0.2
    assert warm["gigabytes"] < 0.09
    assert 0.0 < warm["seconds"]["median"] < 10.0
    assert [(row.case, row.bar, row.reached) for row in rows] == [
        ("cold cache", "90 s", True),
        ("cold cache", "2 GB", True),
        ("warm cache", "20 s", True),
        ("warm cache", "2 GB", True),
    ]

    monkeypatch.setattr(diagnosis, "_command", lambda *_: [sys.executable, "-c", "print(1 / 0)"])
    with pytest.raises(RuntimeError, match="ZeroDivisionError"):
        diagnosis.measure(Bench)


def test_two_checkouts_are_compared_stage_by_stage(monkeypatch, capsys):
    from scripts._bench import checkouts
    from scripts._bench.measures import diagnosis
    from scripts._bench.problem import Scale

    def printed(factor, shrink):
        stages = ["loading", "fitting windows of 0.2 s", "fitting windows of 0.5 s", "screening x"]
        return checkouts.read(
            {
                "stages": [[stage, factor] for stage in stages],
                "verdict": "explained",
                "causes": ["column_tilt"],
                "shrink": shrink,
            }
        )

    def compared(ref, rounds, tell):
        assert (ref, rounds) == ("HEAD~1", 2)
        yield "example", {"here": [printed(1.0, 0.9)] * 2, ref: [printed(3.0, 0.9)] * 2}

    class Bench:
        scale, against, tell = Scale(pairs=2), "HEAD~1", print

    monkeypatch.setattr(checkouts, "compared", compared)
    numbers, rows = diagnosis.measure(Bench)
    assert numbers["example"]["here"]["baseline"] == 2.0
    told = {row.who: row.value for row in rows}
    assert told["in all"] == "12.0 → 4.0 CPU s, 0.33 times"
    assert told["verdict and causes"] == "the same"
    assert capsys.readouterr().out == "example: 12.0 → 4.0 CPU s, 0.33 times\n"
    assert told["shrink"] == "0.900 → 0.900"


def test_the_other_checkout_must_be_known(tmp_path):
    from scripts._bench import checkouts
    from tp_jax.errors import InputError

    with pytest.raises(InputError, match="--against no-such-commit: git knows no such commit"):
        checkouts.unpacked("no-such-commit", tmp_path)


def timed(name, median, error, ours_over):
    """A result as the measures have it."""
    return {
        "peer": name,
        "error": error,
        "seconds": {"median": median},
        "ours_over_peer": {"median": ours_over},
    }


def test_the_faster_method_of_those_that_got_there_is_held_against():
    from scripts._bench.compared import CVODES, against
    from scripts._bench.measures.single import accurate

    ours = timed("tp-jax", 1.0, 1e-6, 1.0)
    bdf, adams = timed("casadi-cvodes", 8.0, 1e-6, 1 / 8), timed("casadi-adams", 5.0, 1e-6, 1 / 5)

    def row(*others):
        (found,) = against("single over cvodes", ("single", ""), [ours, *others], CVODES, accurate)
        return found

    assert row(bdf, adams).value == "1/5 of casadi-adams, the faster of its two methods"
    assert row(bdf, adams).reached
    assert row(bdf, adams | {"error": 1e-3}).value.startswith("1/8 of casadi-cvodes")
    assert row(bdf | {"error": 2e-3}).value == "1/8 of casadi-cvodes, whose error is 2.0e-03"
    assert not row(bdf | {"ours_over_peer": {"median": 0.5}}).reached
    assert against("single over cvodes", ("single", ""), [ours], CVODES, accurate) == []


def test_ours_chooses_from_looser_tolerances_too():
    from scripts._bench import problem
    from scripts._bench.bench import LOOSEST, Bench
    from scripts._bench.peer import Peer

    ours, other = (Peer(name, None, None) for name in ("ours", "other"))
    bench = Bench(problem.Scale(), [ours, other], print)
    assert bench.schedule(other) == bench.scale.tolerances
    schedule = bench.schedule(ours)
    assert schedule[0] == pytest.approx(LOOSEST)
    assert schedule[-len(bench.scale.tolerances) :] == bench.scale.tolerances
    np.testing.assert_allclose(np.diff(np.log10(schedule)), -0.5)


def test_more_rounds_while_there_is_time():
    from scripts._bench.timing import ENOUGH, interleaved

    calls = {"": lambda: time.sleep(0.01)}
    assert len(interleaved(calls, 2, warm=True)[""]) == 2
    assert 2 < len(interleaved(calls, 2, warm=True, budget=0.1)[""]) < ENOUGH


def test_preset_is_the_packages():
    from scripts._bench import problem

    known = presets.values("bench")
    assert dict(zip(problem.NAMES, problem.BENCH, strict=True)) == {
        name: known[name] for name in problem.NAMES
    }
    known = presets.values("paper-5.1")
    assert problem.PAPER == tuple(known[name] for name in problem.NAMES)


def test_equations_are_those_of_the_tests():
    from scripts._bench import equations, problem

    row = problem.bench(B2=0.7, T0=1.3)
    p = {**plain.BENCH, **dict(zip(problem.NAMES, row, strict=True)), "eps": 1e3}
    y = np.array([0.1, -0.2, 0.3, -0.04])
    got = equations.rates(0.3, y, equations.constants(row, 1e3))
    np.testing.assert_allclose(got, plain.right_hand_side(p)(0.3, y), rtol=1e-12)

    step = 1e-7
    c = equations.constants(row, 1e3)
    columns = [
        (equations.rates(0.3, y + e, c) - equations.rates(0.3, y - e, c)) / (2 * step)
        for e in step * np.eye(4)
    ]
    np.testing.assert_allclose(
        equations.jacobian(0.3, y, c), np.array(columns).T, rtol=1e-6, atol=1e-6
    )


def test_what_would_exceed_the_cap_is_not_waited_for():
    from scripts._bench.timing import capped

    asked = []

    def call(duration):
        asked.append(duration)
        time.sleep(0.1 * duration)

    assert capped(call, 100.0, 0.5) == (math.inf, None)
    assert max(asked) < 100.0
    assert capped(call, 1.0, 0.5)[0] == pytest.approx(0.1, abs=0.1)


def test_sweep_is_seeded_and_stays_in_its_spread():
    from scripts._bench import problem

    table = problem.sweep(16)
    np.testing.assert_array_equal(table, problem.sweep(16))
    ratio = table / problem.bench()
    assert np.abs(ratio[:, :10] - 1.0).max() <= 0.2
    np.testing.assert_array_equal(ratio[:, 10], 1.0)


def test_variational_equations_are_the_derivatives():
    from scripts._bench import problem, variational
    from scripts._bench.peers import scipy_lsoda

    ts, row = problem.times(0.2), problem.bench()
    exact = variational.by_lsoda(row, 1e3, ts, 1e-11)
    for column in range(len(problem.VARIED)):
        step = 1e-3 * row[column] * np.eye(row.size)[column]
        up, down = (scipy_lsoda.run(row + s, 1e3, ts, 1e-12) for s in (step, -step))
        got = (up - down) / (2 * step[column])
        np.testing.assert_allclose(
            got, exact[:, :, column], atol=1e-3 * np.abs(exact[:, :, column]).max()
        )
    np.testing.assert_array_equal(exact[0, :, 10:], np.eye(2, 4))


def test_a_peer_that_is_not_installed_is_stated(monkeypatch):
    from scripts._bench.peers import load

    monkeypatch.setitem(sys.modules, "casadi", None)
    monkeypatch.delitem(sys.modules, "scripts._bench.peers.casadi_cvodes", raising=False)
    found, missing = load(("casadi_cvodes",))
    assert found == []
    assert missing == ["casadi_cvodes is skipped: casadi is not installed."]


def test_draws_lie_in_the_bounds_of_their_own_rig():
    from scripts._bench import problem
    from tp_jax.model.parameters import BY_NAME

    for row in problem.anywhere(20):
        drawn = dict(zip(problem.NAMES, row, strict=True))
        for name in problem.VARIED:
            bounds = BY_NAME[name] if name == "B1" else BY_NAME[name].scaled(drawn["B1"])
            assert bounds.lower <= drawn[name] <= bounds.upper
