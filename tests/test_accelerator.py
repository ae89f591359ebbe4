"""scripts/accelerator on the CPU that tests have."""

import numpy as np

from scripts import _accelerator as accelerator


def test_rows_and_runs_to_compare(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(accelerator, "HELD", 4)
    monkeypatch.setattr(accelerator, "SENSITIVE", 4)
    saved = tmp_path / "runs.npz"
    found = accelerator.rows([4], 0.5, str(saved))
    assert [row[1] for row in found] == ["sweep", "sensitivities"] * 2
    assert all(row[5] == "0" and float(row[6]) < 1e-5 for row in found if row[1] == "sweep")
    assert np.load(saved)["phi2 1000"].shape == (4, 126)
    assert capsys.readouterr().out.count("\n") == 4
