"""init, effects, compare and simulate's own numbers."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from scripts._attack import small
from tp_jax.checks import check
from tp_jax.cli import main, simulate
from tp_jax.cli.diagnose import EXAMPLE
from tp_jax.effects import catalogue
from tp_jax.model import presets
from tp_jax.recordings import load_campaign
from tp_jax.report import words

TURN = 2.0 * np.pi


@pytest.fixture(autouse=True)
def _no_cache(monkeypatch):
    monkeypatch.setenv("TP_JAX_CACHE", "off")


# init -----------------------------------------------------------------------------------------


def _run(name: str) -> tuple[np.ndarray, ...]:
    return tuple(np.loadtxt(EXAMPLE / f"{name}.csv", delimiter=",", skiprows=1).T)


def _german(t, a, b) -> str:
    columns = zip(1e3 * t, np.degrees(a), np.degrees(b), strict=True)
    rows = [f"{x:.6f};{y:.9f};{z:.9f}" for x, y, z in columns]
    return "\n".join(["Prüfstand 2;;", "Zeit [ms];Winkel1 [°];Winkel2 [°]", *rows]).replace(
        ".", ","
    )


def _bare(t, a, b) -> str:
    """No header, milliseconds, degrees, a number of each row before them."""
    rows = zip(t, a * 180.0 / np.pi, b * 180.0 / np.pi, strict=True)
    return "\n".join(f"{1e3 * x:.6f}\t{y:.9f}\t{z:.9f}" for x, y, z in rows)


def _counts(t, a, b) -> str:
    x, y = (np.floor(each % TURN / TURN * 4096.0).astype(int) for each in (a, b))
    columns = zip(range(t.size), t, x, y, strict=True)
    rows = "\n".join(f"{i},{s:.6f},{p},{q}" for i, s, p, q in columns)
    return f"sample,time,encoder1,encoder2\n{rows}"


def test_init_takes_no_hour_off_stamps_that_tell_their_offset(tmp_path, capsys):
    t, a, b = _run("run-13")
    t = t + 3600.0 * (t > t[t.size // 2])
    stamps = np.datetime64("2026-03-29T00:59:50") + (1e6 * t).astype("timedelta64[us]")
    rows = [f"{s}Z,{x:.6f},{y:.6f}" for s, x, y in zip(stamps, a, b, strict=True)]
    (tmp_path / "run.csv").write_text("\n".join(["time,phi1,phi2", *rows]))
    assert main(["init", str(tmp_path)]) == 0
    assert "summer" not in "".join(capsys.readouterr())
    assert "summer" not in (tmp_path / "campaign.toml").read_text()


@pytest.mark.filterwarnings("default")
def test_init_tells_of_a_unit_that_it_does_not_know(tmp_path, capsys):
    rows = [f"{s:.6f},{x:.6f},{y:.6f}" for s, x, y in zip(*_run("run-13"), strict=True)]
    header = "time [s],phi1 [furlong],phi2 [rad]"
    (tmp_path / "run.csv").write_text("\n".join([header, *rows]))
    assert main(["init", str(tmp_path)]) == 0
    told = capsys.readouterr().err
    assert "phi1 is in 'furlong', says the file, which is no unit of an angle" in told
    assert "phi2" not in told
    assert "the file says 'furlong'" in (tmp_path / "campaign.toml").read_text()


@pytest.mark.parametrize(
    ("write", "within"),
    [(_german, 1e-6), (_bare, 1e-6), (_counts, 5e-3)],
    ids=["german", "bare", "counts"],
)
def test_init_finds_what_was_written(write, within, tmp_path, capsys):
    for name in ("run-13", "run-17", "decay"):
        (tmp_path / f"{name}.txt").write_text(write(*_run(name)), encoding="utf-8")
    (tmp_path / "notes.md").write_text("no data")
    assert main(["init", str(tmp_path)]) == 0
    assert "Read and correct it" in capsys.readouterr().out
    campaign = load_campaign(tmp_path)
    assert check(tmp_path).wrong == ()
    driven = {r.name: r.omega for r in campaign.recordings}
    assert driven["decay.txt"] is None
    assert driven["run-13.txt"] == pytest.approx(13.09, abs=2e-3)
    assert driven["run-17.txt"] == pytest.approx(17.0, abs=2e-3)
    for recording in campaign.recordings:
        t, a, b = _run(recording.name.removesuffix(".txt"))
        np.testing.assert_allclose(recording.t, t, atol=1e-6)
        np.testing.assert_allclose(recording.phi1, a, atol=within)
        off = recording.phi2 - b
        np.testing.assert_allclose(off - TURN * np.round(off[0] / TURN), 0.0, atol=within)


def test_init_overwrites_nothing(tmp_path, capsys):
    (tmp_path / "campaign.toml").write_text("name = 'mine'")
    assert main(["init", str(tmp_path)]) == 2
    assert "is there already" in capsys.readouterr().err
    assert (tmp_path / "campaign.toml").read_text() == "name = 'mine'"


@pytest.mark.filterwarnings("default")  # what is left out is a notice
@pytest.mark.parametrize("files", [{}, {"a.csv": "no numbers"}, {"a.csv": ""}])
def test_init_without_data(files, tmp_path, capsys):
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    assert main(["init", str(tmp_path)]) == 2
    assert "put the recordings there" in capsys.readouterr().err
    assert main(["init", str(tmp_path / "none")]) == 2


@pytest.mark.filterwarnings("default")
def test_init_names_what_it_left_out(tmp_path, capsys):
    (tmp_path / "a.csv").write_text(_german(*_run("run-13")))
    (tmp_path / "b.csv").write_text(_counts(*_run("run-17")))
    (tmp_path / "c.pdf2").write_bytes(b"%PDF-1.7")
    assert main(["init", str(tmp_path)]) == 0
    err = capsys.readouterr().err
    assert "b.csv: its columns differ" in err
    assert "c.pdf2: this is a PDF" in err


# effects ----------------------------------------------------------------------------------------


def test_effects_are_listed(capsys):
    assert main(["effects"]) == 0
    out = capsys.readouterr().out
    assert all(f"{name} " in out for name in catalogue())


def test_one_effect_is_told(capsys):
    assert main(["effects", "contact_stribeck"]) == 0
    out = capsys.readouterr().out
    assert words.EFFECTS["contact_stribeck"] in out
    assert catalogue()["contact_stribeck"].remedy in out
    assert catalogue()["contact_stribeck"].by_hand in out


def test_an_effect_that_is_not_there(capsys):
    assert main(["effects", "contact_stribek"]) == 2
    assert "did you mean contact_stribeck?" in capsys.readouterr().err


def test_effects_as_json(capsys):
    assert main(["effects", "--json", "-"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert set(told) == set(catalogue())
    assert all(each["says"] and each["remedy"] and each["formula"] for each in told.values())


# compare ------------------------------------------------------------------------------------------


def _diagnosis(tmp_path, name, k, causes):
    content = small.diagnosis()
    content |= {"campaign": name, "verdict": "explained" if causes else "no_gap", "causes": causes}
    content["parameters"] = {
        "k": {"value": k, "unit": "N m/rad", "ci95": [k - 0.01, k + 0.01], "identifiable": True}
    }
    (tmp_path / name).mkdir()
    (tmp_path / name / "diagnosis.json").write_text(json.dumps(content))
    return str(tmp_path / name)


CAUSE = {
    "effect": "contact_stribeck",
    "location": "contact",
    "probability": 0.99,
    "shrink": 0.9,
    "parameters": {"a": {"value": 0.5, "unit": "1", "ci95": [0.4, 0.6]}},
}


@pytest.mark.parametrize(("k", "star"), [(0.45, False), (0.48, True)])
def test_compare(k, star, tmp_path, capsys):
    a, b = _diagnosis(tmp_path, "old", 0.45, [CAUSE]), _diagnosis(tmp_path, "new", k, [])
    page = tmp_path / "c.html"
    assert main(["compare", a, b, "--html", str(page), "--json", str(tmp_path / "c.json")]) == 0
    out = capsys.readouterr().out
    assert ("k *" in out) is star
    lines = {line.split("  ")[0]: line for line in out.split("\n")}
    assert "not found" in lines["cause contact_stribeck"]
    assert "0.500 (0.400 to 0.600)" in lines["cause contact_stribeck"]
    found = json.loads((tmp_path / "c.json").read_text())
    assert found["verdicts"] == ["explained", "no_gap"]
    assert found["parameters"]["k"]["differs"] is star
    assert "<script" not in page.read_text()
    assert "contact_stribeck" in page.read_text()


def test_an_interval_that_is_missing_has_its_place(tmp_path):
    a, b = (_diagnosis(tmp_path, name, 0.45, []) for name in ("a", "b"))
    file = Path(a) / "diagnosis.json"
    content = json.loads(file.read_text())
    del content["parameters"]["k"]["ci95"]
    file.write_text(json.dumps(content))
    out = tmp_path / "c.json"
    assert main(["compare", a, b, "--json", str(out)]) == 0
    assert json.loads(out.read_text())["parameters"]["k"]["ci95"] == [None, [0.44, 0.46]]


def test_compare_what_is_no_diagnosis(tmp_path, capsys):
    (tmp_path / "a.json").write_text("{}")
    assert main(["compare", str(tmp_path / "a.json"), str(tmp_path / "a.json")]) == 2
    assert "a.json" in capsys.readouterr().err


# simulate -----------------------------------------------------------------------------------------


def test_numbers_are_those_of_the_model():
    assert {*simulate.COLUMN, *simulate.RIDER} == {*presets.values("bench"), "phase"}


def _simulated(capsys, *argv) -> np.ndarray:
    assert main(["simulate", "--preset", "bench", "--duration", "2", "--quiet", *argv]) == 0
    return np.array([row.split(",") for row in capsys.readouterr().out.split("\n")[1:-1]], float)


def test_a_released_column_swings_at_its_own_frequency(capsys):
    free = [f"--set={name}=0" for name in ("c1", "M1")]
    y = _simulated(capsys, "--single", "--phi1", "0.3", "--set", "k=0.48", *free)
    assert y.shape[1] == 2
    np.testing.assert_allclose(y[:, 1], 0.3 * np.cos(20.0 * y[:, 0]), atol=1e-5)


@pytest.mark.parametrize(
    ("argv", "says"),
    [
        (["--set", "K=1"], "names K"),
        (["--set", "B2=1", "--single"], "without a rider"),
        (["--set", "B1=0"], "above zero"),
        (["--set", "Tv=-1"], "below zero"),
        (["--set", "k=1", "--set", "k=2"], "only once"),
    ],
)
def test_numbers_that_cannot_be(argv, says, capsys):
    assert main(["simulate", *argv]) == 2
    assert says in capsys.readouterr().err


# Recordings stay --------------------------------------------------------------------------------


SHORT = ["simulate", "--preset", "bench", "--duration", "0.4", "--quiet"]


def _beside(kind, file) -> None:
    """Makes a file a recording: by metadata, or by a campaign that lists it."""
    if kind == "metadata":
        file.with_name(f"{file.name}.meta.json").write_text("{}")
    else:
        text = f"[[recording]]\nfile = './{file.name}'\nomega = 3.0\n"
        (file.parent / "campaign.toml").write_text(text)


@pytest.mark.parametrize("kind", ["metadata", "campaign"])
def test_a_recording_is_not_replaced_unasked(kind, tmp_path, capsys):
    file = tmp_path / "run-13.csv"
    file.write_text("t,phi1,phi2\n0,0,0\n")
    _beside(kind, file)
    before = {each: each.read_bytes() for each in tmp_path.iterdir()}
    assert main([*SHORT, "--out", str(file)]) == 2
    told = capsys.readouterr().err
    assert "run-13.csv is a recording; choose another name, or add --overwrite" in told
    assert {each: each.read_bytes() for each in tmp_path.iterdir()} == before


def test_a_link_to_a_recording_neither(tmp_path, capsys):
    file = tmp_path / "run-13.csv"
    file.write_text("t,phi1\n")
    _beside("metadata", file)
    (tmp_path / "link.csv").symlink_to(file)
    assert main([*SHORT, "--out", str(tmp_path / "link.csv")]) == 2
    assert file.read_text() == "t,phi1\n"


def test_metadata_whose_recording_is_elsewhere_stay(tmp_path):
    file = tmp_path / "run-13.csv"
    _beside("metadata", file)
    assert main([*SHORT, "--out", str(file)]) == 2
    assert [each.name for each in tmp_path.iterdir()] == ["run-13.csv.meta.json"]


def test_a_recording_is_replaced_where_that_is_said(tmp_path):
    file = tmp_path / "run-13.csv"
    file.write_text("t,phi1,phi2\n")
    _beside("metadata", file)
    assert main([*SHORT, "--out", str(file), "--overwrite"]) == 0
    assert len(file.read_text().splitlines()) == 102
    # what was known of the recording is not true of what was simulated
    assert [each.name for each in tmp_path.iterdir()] == ["run-13.csv"]


def test_what_was_simulated_is_replaced_as_before(tmp_path):
    file = tmp_path / "run.csv"
    for _ in range(2):
        assert main([*SHORT, "--out", str(file)]) == 0


@pytest.mark.parametrize(
    "argv",
    [
        ["check", str(EXAMPLE), "--json"],
        ["identify", str(EXAMPLE), "--json"],
        ["predict", "no.json", "--omega", "3", "--duration", "1", "--rate", "100", "--out"],
    ],
    ids=lambda argv: argv[0],
)
def test_other_commands_replace_none_either(argv, tmp_path, capsys):
    file = tmp_path / "run-13.csv"
    file.write_text("t,phi1,phi2\n")
    _beside("metadata", file)
    assert main([*argv, str(file)]) == 2
    assert "is a recording; choose another name" in capsys.readouterr().err
    assert file.read_text() == "t,phi1,phi2\n"


# one file, without a campaign.toml --------------------------------------------------------------


def _of_one_file(told: str) -> str:
    return re.search(r"single file without a campaign\.toml: (--omega [\d.]+)", told)[1]


# of another frequency only that of the motion is known
@pytest.mark.parametrize(
    ("given", "within"),
    [(13.09 / TURN, 1e-5), (60.0 * 13.09 / TURN, 1e-5), (TURN / 13.09, 1e-5), (9.4, 1e-3)],
)
def test_the_frequency_that_is_advised_for_one_file_is_right(given, within, capsys):
    file = str(EXAMPLE / "run-13.csv")
    assert main(["check", file, "--omega", f"{given}"]) == 2
    option = _of_one_file(capsys.readouterr().out).split()
    assert main(["check", file, *option]) == 0
    assert float(option[1]) == pytest.approx(13.09, rel=within)


def test_what_one_file_needs_a_campaign_toml_for_goes_into_the_one_of_init(tmp_path, capsys):
    t, a, b = _run("run-13")
    rows = zip(1e3 * t, a, b, strict=True)
    text = "\n".join(["t,phi1,phi2", *(f"{x:.6f},{y:.9f},{z:.9f}" for x, y, z in rows)])
    (file := tmp_path / "a run.csv").write_text(text)
    init = f"tp-jax init '{tmp_path}'" if " " in str(tmp_path) else f"tp-jax init {tmp_path}"
    for command in (["check"], ["identify", "--quiet"]):
        assert main([*command, str(file), "--omega", "13.09"]) == 2
        said = capsys.readouterr()
        assert f"`{init}` writes" in said.out + said.err
    assert main(["init", str(tmp_path)]) == 0
    assert main(["check", str(file), "--omega", "13.09"]) == 2
    assert f"belongs in {tmp_path / 'campaign.toml'}; then name" in capsys.readouterr().out
