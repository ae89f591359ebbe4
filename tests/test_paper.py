"""scripts/paper: its quick version, and what its numbers must say."""

import json

import numpy as np
import pytest


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    """Runs it once and gives its JSON and its folder."""
    folder = tmp_path_factory.mktemp("paper")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TP_JAX_CACHE", "off")
        from scripts._paper.__main__ import main

        assert main(["--quick", "--out", str(folder)]) == 0
    return json.loads((folder / "paper.json").read_text(encoding="utf-8")), folder


@pytest.mark.slow
def test_no_slip_in_section_5_1(result):
    by_eps = result[0]["contact"]["by_eps"]
    coarse, slipping, fine, slipping_fine = by_eps
    assert coarse["largest_torque"] < result[0]["contact"]["breakaway"]
    # creep of a body that sticks goes with the smoothing, slip does not
    assert fine["largest_phi2"] < 0.02 * coarse["largest_phi2"]
    assert slipping_fine["largest_phi2"] == pytest.approx(slipping["largest_phi2"], rel=0.05)
    # the set on which Ts2 acts: the first sample, at rest
    assert all(run["samples_at_rest_exactly"] <= 1 for run in by_eps)


@pytest.mark.slow
def test_what_no_angle_shows(result):
    unseen = result[0]["unseen"]
    assert unseen["newton_with_the_column_halved"] == 0.0
    assert unseen["Ts2_times_100"] == 0.0
    assert unseen["all_torques_times_7"] < 1e-10
    assert unseen["newton_with_nothing_changed"] > 0.01


@pytest.mark.slow
def test_what_the_objective_sees(result):
    seen = result[0]["seen"]
    quiet, moving = seen["printed"]["y"], seen["slipping"]["y"]
    assert quiet["Ts2"] == moving["Ts2"] == 0.0
    for name in ("Tv", "Tst", "T0"):
        assert quiet[name] < 1e-3 * seen["detectable"]
        assert moving[name] > quiet[name]
    assert quiet["k"] > seen["detectable"]


@pytest.mark.slow
def test_null_directions_are_found(result):
    structure = result[0]["structure"]
    assert structure["eleven"]["rank"] == structure["with_factor"]["rank"] == 9
    assert len(structure["with_factor"]["null_directions"]) == 3


@pytest.mark.slow
def test_methods(result):
    for run in result[0]["section_5_1"]["runs"].values():
        rows = {row["method"]: row for row in run["methods"]}
        assert len(rows) == 4
        for row in rows.values():
            assert row["evaluations"] > 0
            assert np.isfinite(row["y"])
            assert row["y"] < run["y_start"]
        history = rows["Nelder-Mead, thousands"]["history"]
        assert (np.diff(history["y"]) <= 0.0).all()
        assert rows["gradients, windows"]["y"] < rows["Nelder-Mead, thousands"]["y"]


@pytest.mark.slow
def test_figures(result):
    drawn = {path.stem for path in result[1].glob("*.png")}
    figures = {f"figure-{n:02d}" for n in range(9, 14)}
    assert drawn == figures | {"progress", "what-y-sees", "no-slip"}


def test_the_order_is_that_of_listing_1():
    from scripts._paper.objective import LISTING_START, ORDER

    assert ORDER == ("B1", "B2", "k", "A", "c1", "M1", "Tv", "Ts1", "Ts2", "Tst", "T0")
    assert LISTING_START == (1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 100)


def test_y_is_that_of_17():
    from scripts._paper.objective import Objective
    from tp_jax.simulation.solve import Trajectory

    ts = np.linspace(0.0, 1.0, 5)
    objective = Objective(ts, np.zeros(5), np.ones(5), 1.0)
    motion = Trajectory(ts, np.full(5, 0.2), np.full(5, 1.1), ts, ts)
    assert objective.of(motion) == pytest.approx(0.5 * (0.04 + 0.01))
    assert objective.of(motion._replace(phi1=np.full(5, np.inf))) == np.inf
    assert objective.of_rest == pytest.approx(0.5)


def test_the_first_simplex_is_fminsearchs():
    from scripts._paper.nelder_mead import search

    class Bowl:
        def __init__(self):
            self.seen, self.history, self.evaluations = [], [], 0

        def fresh(self):
            return self

        def __call__(self, x):
            self.seen.append(np.array(x))
            self.history.append(float(((x - 3.0) ** 2).sum()))
            self.evaluations += 1
            return self.history[-1]

    bowl = Bowl()
    found = search(bowl, np.ones(11), 50)
    assert np.array_equal(bowl.seen[0], np.ones(11))
    for i in range(11):
        assert bowl.seen[1 + i] == pytest.approx(np.where(np.arange(11) == i, 1.05, 1.0))
    assert found.evaluations == len(bowl.seen)
    assert found.history == sorted(found.history, reverse=True)


def test_errors_do_not_see_the_scale():
    from scripts._paper.objective import of_preset
    from scripts._paper.section_5_1 import errors, stuck_errors

    truth = of_preset("paper-5.1")
    scaled = truth * np.where(np.isin(np.arange(11), (3, 10)), 1.0, 7.0)
    assert errors(scaled, truth) == pytest.approx({n: 0.0 for n in errors(truth, truth)})
    assert stuck_errors(scaled, truth) == pytest.approx(
        {n: 0.0 for n in stuck_errors(truth, truth)}
    )
