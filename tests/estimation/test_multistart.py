"""A search from many starts: who meets whom, what fails, and going on after Ctrl-C."""

import numpy as np
import pytest

from tests.rigs import synthetic_campaign
from tests.standing_in import standing_in
from tp_jax.estimation import multistart
from tp_jax.estimation.checkpoint import Checkpoint
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.multistart import Interrupted, search
from tp_jax.estimation.prepared_campaign import prepare_campaign
from tp_jax.estimation.schedule import Schedule
from tp_jax.estimation.start import initial_values
from tp_jax.estimation.starts import Start

HELD = ("B2", "A", "c1", "M1", "Tv", "Ts1", "Tst", "T0")


def silent(stage, fraction):
    pass


class Wells(Schedule):
    """In place of a ladder: two optima in log k, at 0 and at 3, the second 40 worse; no motion
    beyond log k of 5, no solution beyond 8."""

    def __init__(self):
        campaign = synthetic_campaign(duration=0.5)
        super().__init__(prepare_campaign(campaign, effects=(), fix=dict.fromkeys(HELD, 1.0)))
        self.problem = self.setting.problem(0.2)
        self.calls: list[str] = []
        self.stop_at = None

    def _fit(self, kind, values, log_k, cost, evaluations):
        self.calls.append(kind)
        if len(self.calls) == self.stop_at:
            raise KeyboardInterrupt
        unknowns = self.setting.unknowns()
        H = np.zeros((3, 3))
        H[0, 0] = 1e4 / np.exp(log_k) ** 2  # a hundredth is one standard error of log k
        return standing_in(
            Fit,
            problem=self.problem,
            values=values.replace({"k": np.exp(log_k)}),
            unknowns=unknowns,
            cost=cost,
            chi2_dof=1.0,
            information=lambda: H,
            evaluations=evaluations,
            converged=bool(np.isfinite(cost)),
            message=f"From {kind}.",
            states=np.full((2, 4), log_k),
        )

    def first(self, values):
        k = np.log(values.get("k"))
        if k > 8.0:
            raise np.linalg.LinAlgError("singular")
        if k > 5.0:
            return self._fit("first", values, k, np.inf, 1)
        end = 0.0 if k < 1.5 else 3.0
        # ends are not quite the same
        return self._fit("first", values, end + 1e-3 * np.sin(k), 100.0 + 40.0 * (end > 0.0), 7)

    def run(self, values):
        k = np.log(values.get("k"))
        return self._fit("run", values, k, 1000.0 + 400.0 * (k > 1.5), 11)

    def as_it_is(self, values):
        k = np.log(values.get("k"))
        return self._fit("as it is", values, k, 5000.0, 2)

    def coordinates(self, x):
        return np.array([np.log(x[0]), *x[1:]])


def begun(schedule, *log_k):
    values = initial_values(schedule.setting)
    return [Start(values.replace({"k": np.exp(each)}), None) for each in log_k]


@pytest.fixture
def schedule():
    return Wells()


def test_starts_that_meet_go_on_as_one(schedule):
    trials = search(begun(schedule, -1.0, 0.5, 1.0, 2.0, 2.5), schedule, progress=silent)
    assert [t.end.cost for t in trials] == [1000.0] * 3 + [1400.0] * 2
    assert schedule.calls.count("run") == 2
    assert [t.met for t in trials] == [trials[0].met] * 3 + [trials[3].met] * 2
    assert [t.alone for t in trials] == [18] * 5
    records = [t.record(i) for i, t in enumerate(trials)]
    alone = [i for i, r in enumerate(records) if not r["message"].startswith("Met start")]
    assert len(alone) == 2
    assert [r["evaluations"] for r in records] == [18 if i in alone else 7 for i in range(5)]
    assert all(r["converged"] for r in records)
    assert records[alone[0]]["message"] == "From run."


def test_failures_are_told(schedule):
    trials = search(begun(schedule, 0.0, 6.0, 9.0), schedule, progress=silent)
    records = [t.record(i) for i, t in enumerate(trials)]
    assert [r["objective"] for r in records] == [1000.0, None, None]
    assert [r["converged"] for r in records] == [True, False, False]
    assert "could not be solved" in records[2]["message"]


def test_what_is_far_worse_stays_behind(schedule, monkeypatch):
    monkeypatch.setattr(multistart, "BEHIND", 0.3)
    trials = search(begun(schedule, 0.0, 3.0), schedule, progress=silent)
    assert trials[1].end.cost == 5000.0
    assert not trials[1].end.converged
    assert trials[1].record(1)["message"].startswith("Left behind")
    assert schedule.calls.count("run") == 1


def test_progress_is_told(schedule):
    told = []
    search(begun(schedule, *np.linspace(0, 1, 9)), schedule, progress=lambda *a: told.append(a))
    assert told == [
        ("starts, 9 in all", 0.0),
        ("starts, 9 in all", pytest.approx(4 / 9)),
        ("starts, 9 in all", pytest.approx(8 / 9)),
        ("optima, 1 in all", 0.0),
    ]


LOG_K = (-1.0, 0.5, 6.0, 1.0, 2.0, 2.5, 0.0, 0.1, 0.2)


def key(trials):
    return [
        (t.end.x.tolist(), t.end.cost, t.met, t.alone, t.record(i)) for i, t in enumerate(trials)
    ]


@pytest.mark.parametrize("stop_at", [2, 5, 7, 10, 11])
def test_ctrl_c_keeps_what_is_done(tmp_path, stop_at):
    whole = search(begun(Wells(), *LOG_K), Wells(), progress=silent)
    path = tmp_path / "starts.json"
    schedule = Wells()
    schedule.stop_at = stop_at
    kept = Checkpoint(path, {"seed": 0})
    with pytest.raises(Interrupted) as stopped:
        search(begun(schedule, *LOG_K), schedule, checkpoint=kept, progress=silent)
    assert isinstance(stopped.value, KeyboardInterrupt)
    done = min(4 * ((stop_at - 1) // 4), 9) if stop_at <= 9 else 9
    assert str(stopped.value).startswith(f"Interrupted after {done} of 9 starts")
    assert "--resume" in str(stopped.value)

    again, schedule = Checkpoint(path, {"seed": 0}), Wells()
    if done:
        assert again.resume() >= done
    trials = search(begun(schedule, *LOG_K), schedule, checkpoint=again, progress=silent)
    assert schedule.calls.count("first") == 9 - done
    assert key(trials) == key(whole)


def test_without_a_file_they_are_lost(schedule):
    schedule.stop_at = 6
    with pytest.raises(Interrupted, match="which are lost"):
        search(begun(schedule, *LOG_K), schedule, progress=silent)


def test_more_starts_go_on_from_fewer(tmp_path, schedule):
    path = tmp_path / "starts.json"
    search(begun(schedule, *LOG_K[:4]), schedule, checkpoint=Checkpoint(path, {}), progress=silent)
    again, more = Checkpoint(path, {}), Wells()
    again.resume()
    trials = search(begun(more, *LOG_K), more, checkpoint=again, progress=silent)
    assert more.calls.count("first") == 5
    assert [t.end.cost for t in trials] == [
        t.end.cost for t in search(begun(Wells(), *LOG_K), Wells(), progress=silent)
    ]
