"""scripts/methods tabulates what each method found."""

import pytest

from scripts import _methods


def test_a_table(monkeypatch, capsys):
    ends = {"least-squares": (100.5, 10.0), "bfgs": (100.0, 45.0)}

    def identified(folder, method):
        objective, seconds = ends[method]
        start = {"converged": method == "bfgs", "evaluations": 7}
        return {
            "campaign": "rig",
            "objective": objective,
            "chi2_dof": 1.0,
            "starts": [start],
        }, seconds

    monkeypatch.setattr(_methods, "_identified", identified)
    assert _methods.main(["rig", "--methods", *ends]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[2] == "| rig | `least-squares` | 0.5 | 1 | at its limit | 7 | 10 (1.0×) |"
    assert lines[3] == "| rig | `bfgs` | 0.0 | 1 | yes | 7 | 45 (4.5×) |"


def test_a_method_that_has_another_objective_is_refused():
    with pytest.raises(SystemExit):
        _methods.main(["--methods", "nelder-mead"])
