"""scripts/coverage: two small rigs, resumed; the counting on results made up."""

import json

import pytest


def row(truth, low, high, **more):
    held = (low is None or low <= truth) and (high is None or truth <= high)
    return {
        "truth": truth,
        "value": truth,
        "ci95": [low, high],
        "covered": held,
        "open": None in (low, high),
        **more,
    }


def test_shares():
    from scripts._coverage.tally import lines, tally

    results = {
        i: {"parameters": {"k": row(1.0, 0.9, 1.1 if i < 95 else 0.95), "T0": row(4.0, 3.0, None)}}
        for i in range(100)
    }
    found = tally(results)
    assert (found["k"]["covered"], found["k"]["of"], found["k"]["open"]) == (95, 100, 0)
    assert found["k"]["within_target"]
    low, high = found["k"]["ci95"]
    assert low < 0.95 < high
    assert found["T0"]["open"] == 100
    assert found["T0"]["by"] == "profile"
    assert found["T0"]["half_width"] is None
    assert len(lines(found)) == 3


def test_a_line_that_was_cut_off_does_not_count(tmp_path):
    from scripts._coverage.pool import mend, read

    path = tmp_path / "rigs.jsonl"
    path.write_text('{"rig": 0}\n{"rig": 1, "para')
    assert list(read(path)) == [0]
    mend(path)
    with path.open("a") as file:
        file.write('{"rig": 2}\n')
    assert list(read(path)) == [0, 2]


def test_another_study_is_not_gone_on_with(tmp_path, capsys):
    from scripts._coverage.__main__ import main
    from scripts._coverage.settings import Settings
    from tp_jax.cli.output import write_json

    write_json(tmp_path / "settings.json", Settings(runs=4)._asdict())
    assert main(["--out", str(tmp_path), "--rigs", "1"]) == 2
    assert "other settings" in capsys.readouterr().err


@pytest.mark.slow
def test_a_small_study_and_its_resumption(tmp_path, monkeypatch, capsys):
    from scripts._coverage.__main__ import main

    monkeypatch.setenv("TP_JAX_CACHE", "off")
    argv = ["--quick", "--out", str(tmp_path), "--workers", "1"]
    assert main([*argv, "--rigs", "1"]) == 0
    first = (tmp_path / "rigs.jsonl").read_text()
    assert main([*argv, "--rigs", "2"]) == 0
    assert (tmp_path / "rigs.jsonl").read_text().startswith(first)
    result = json.loads((tmp_path / "coverage.json").read_text())
    assert result["schema"] == "tp-jax/coverage/1"
    assert result["rigs"] == 2
    assert set(result["parameters"]) == {"B2", "k", "A", "c1", "M1", "Tv", "Ts1", "Tst", "T0"}
    for name, found in result["parameters"].items():
        assert found["of"] == 2, name
    assert "by_standard_error" in result["parameters"]["T0"]
    assert (tmp_path / "coverage.png").is_file()
    assert "held" in capsys.readouterr().out
