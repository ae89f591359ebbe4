"""The command line: what it prints where, its exit codes, and that it answers at once."""

import errno
import importlib
import json
import os
import subprocess
import sys
import warnings
from datetime import date
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import tp_jax
from scripts._attack import small
from tp_jax.cli import arguments, main, sensitivity
from tp_jax.cli.arguments import sample_count
from tp_jax.cli.diagnose import EXAMPLE, default_folder
from tp_jax.cli.simulate import PRESETS
from tp_jax.errors import InputError, Notice
from tp_jax.model import plausible

ROOT = Path(__file__).parent.parent.parent
RECORD = ("record", "--port", "emulator", "--duration", "1", "--out", "new.csv")
COMMANDS = ("simulate", "identify", "diagnose", "predict")


@pytest.fixture(autouse=True)
def _no_cache(monkeypatch):
    monkeypatch.setenv("TP_JAX_CACHE", "off")


def put(monkeypatch, name, value):
    """In the place of one of the package's lazy names."""
    monkeypatch.setitem(vars(tp_jax), name, value)


# Answering at once ---------------------------------------------------------------------------


@pytest.mark.parametrize("argv", [["--help"], *([command, "--help"] for command in COMMANDS)])
def test_help_loads_nothing_heavy(argv):
    done = subprocess.run(
        [sys.executable, "-X", "importtime", "-m", "tp_jax", *argv],
        check=True,
        capture_output=True,
        text=True,
        cwd=ROOT,
    )
    loaded = {line.rpartition("|")[2].strip().partition(".")[0] for line in done.stderr.split("\n")}
    assert "tp_jax" in loaded
    assert loaded.isdisjoint({"jax", "jaxlib", "numpy", "scipy", "equinox", "diffrax", "rich"})


def test_help_names_the_commands(capsys):
    assert main(["--help"]) == 0
    text = capsys.readouterr().out
    assert all(command in text for command in COMMANDS)
    assert "blind" not in text


def test_version(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"tp-jax {tp_jax.__version__}\n"


# Faults --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("argv", "part"),
    [
        ([], "COMMAND"),
        (["bogus"], "bogus"),
        (["simulate", "--preset", "unknown"], "unknown"),
        (["simulate", "--duration", "-1"], "--duration must be above zero"),
        (["simulate", "--duration", "nan"], "--duration must be a number"),
        (["simulate", "--rate", "-250"], "--rate must be above zero"),
        (["simulate", "--rate", "inf"], "--rate must be a number"),
        (["simulate", "--rate", "fast"], "--rate must be a number, but is 'fast'"),
        (["simulate", "--duration", "1e9"], "samples"),
        (["simulate", "--duration", "1e308", "--rate", "1e308"], "samples"),
        (["simulate", "--duration", "1e-3", "--rate", "1"], "samples"),
        (["simulate", "extra"], "extra"),
        (["identify"], "CAMPAIGN"),
        (["identify", "c", "--fix", "k=abc"], "--fix must give k a number"),
        (["identify", "c", "--fix", "k"], "NAME=V"),
        (["identify", "c", "--fix", "=1"], "NAME=V"),
        (["identify", "c", "--fix", "k=1", "--fix", "k=2"], "only once"),
        (["identify", "c", "--bound", "k=1"], "NAME=LO:HI"),
        (["identify", "c", "--bound", "k=1:x"], "two numbers"),
        (["identify", "c", "--bound", "k=2:1"], "from below"),
        (["identify", "c", "--starts", "0"], "--starts must be a whole number"),
        (["identify", "c", "--starts", "2.5"], "--starts must be a whole number"),
        (["identify", "c", "--seed", "-1"], "--seed must be a whole number"),
        (["identify", "c", "--method", "magic"], "magic"),
        (["identify", "c", "--model", "einstein"], "einstein"),
        (["diagnose", "c", "--omega", "2", "--decay"], "--decay"),
        (["diagnose", "c", "--omega", "-2"], "--omega must not be negative"),
        (["predict", "d.json"], "--omega"),
        (["predict", "d.json", "--omega", "3", "--phi1", "2"], "--phi1"),
        (["predict", "d.json", "--omega", "3", "--rate", "10"], "--duration is needed"),
        (["predict", "d.json", "--omega", "3", "--duration", "10"], "--rate is needed"),
        (["predict", "d.json", "--omega", "3", "--duration", "1e9", "--rate", "1e9"], "samples"),
        (["predict", "d.json", "--phi1", "1", "--duration", "1e15", "--rate", "9"], "EB of memory"),
        (["predict", "d.json", "--phi1", "1", "--duration", "1e-9", "--rate", "9"], "samples"),
        (["predict", "d.json", "--phi1", "1", "--duration", "1", "--rate", "1e12"], "600 TB"),
        (["predict", "d.json", "--phi1", "1e300", "--duration", "1", "--rate", "9"], "100 rad"),
        (["predict", "d.json", "--omega", "1e9", "--duration", "1", "--rate", "9"], "10000 rad/s"),
        (["simulate", "--duration", "1e308"], "of memory"),
        (["simulate", "--duration", "1e308", "--rate", "1e-307"], "at most 1e+07 s"),
        (["simulate", "--out", "x" * 300], "file name too long"),
        (["simulate", "--out", "/dev/null/x"], "/dev/null"),
        (["simulate", "--plot", "-"], "--plot must name a file"),
        (["compare", "a", "b", "--html", "-"], "--html must name a file"),
        (["check", EXAMPLE, "--figure", "-"], "--figure must name a file"),
        ([*RECORD[:-1], "-"], "--out must name a file"),
        (["identify", "x" * 300], "xxx"),
        (["identify", EXAMPLE, "--json", "x" * 300], "file name too long"),
        (["identify", EXAMPLE, "--json", "/dev/null/x.json"], "/dev/null"),
        (["identify", EXAMPLE, "--bound", "k=1e300:1e308"], "The bounds of k must lie between"),
        (["identify", EXAMPLE, "--bound", "k=0:1e-300"], "The bounds of k must lie between"),
        (["identify", EXAMPLE, "--bound", "k=-1:1"], "k must not be negative"),
        (["identify", EXAMPLE, "--bound", "T0=0:1e308", "--raw-starts"], "The bounds of T0"),
        (["identify", EXAMPLE, "--fix", "k=1e308"], "Parameter k must lie between"),
        (["identify", EXAMPLE, "--fix", "B2=1e300"], "Parameter B2 must lie between"),
        (["identify", EXAMPLE, "--fix", "B1=1e300"], "Parameter B1 must lie between"),
        (["identify", EXAMPLE, "--fix", "magic=1"], "no parameter 'magic'"),
        (["identify", EXAMPLE, "--starts", "10" * 20], "--starts must be at most"),
        (["sensitivity", EXAMPLE, "--fix", "k=-1"], "k must be above zero"),
        (["sensitivity", EXAMPLE, "--spread", "1e300"], "--spread must be a factor above 1"),
        (["sensitivity", EXAMPLE, "--spread", "1"], "--spread must be a factor above 1"),
        (["sensitivity", EXAMPLE, "--samples", "100"], "--samples must be a power of two"),
        (["sensitivity", EXAMPLE, "--samples", str(2**60)], "--samples must be at most"),
        (["sensitivity", EXAMPLE, "--profile", "nope"], "no parameter 'nope'"),
        (["sensitivity", EXAMPLE, "--profile", "k", "--fix", "k=1"], "which --fix holds"),
        (["diagnose", EXAMPLE, "--out", "x" * 300], "file name too long"),
        (["diagnose", EXAMPLE, "--seed", "1" * 400], "--seed must be at most"),
        ([*RECORD, "--baud", "9" * 20], "--baud must be at most"),
        ([*RECORD, "--patience", "1e300"], "--patience must be at most"),
        ([*RECORD, "--release", "1e300"], "--release must be at most 100 rad"),
        ([*RECORD[:-1], "x" * 300], "File name too long"),
        ([*RECORD[:-2], "--campaign", "x" * 300], "File name too long"),
        (["rig", "serve", "--rate", "1e300"], "--rate must be at most"),
        (["rig", "serve", "--text", "--release", "1e300"], "--release must be at most"),
        (["rig", "serve", "--unplug", "1e300:1"], "must be at most"),
        (["calibrate", "x" * 300, "--out", "x" * 300], "File name too long"),
        (["diagnose", EXAMPLE, "--tolerance", "nan"], "--tolerance must be a number"),
        (["diagnose", EXAMPLE, "--tolerance", "1e308"], "--tolerance must be at most 100 rad"),
        (["diagnose", EXAMPLE, "--tolerance", "-1"], "--tolerance must not be negative"),
        (["blind", "make", "b", "--cases", "9"], "./scripts/blind make"),
        (["blind", "score", "b", "--json", "-"], "./scripts/blind score"),
        (["blind", "--help"], "in a clone of the repository"),
        (["blind"], "in a clone of the repository"),
        (["predict", "missing.json", "--omega", "3", "--duration", "1", "--rate", "9"], "missing"),
    ],
)
def test_bad_arguments_are_told_in_one_sentence(argv, part, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main([str(word) for word in argv]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.startswith("tp-jax: ")
    assert told.err.count("\n") == 1
    assert told.err.endswith(".\n")
    assert part in told.err


@pytest.mark.parametrize(
    "argv",
    [
        ["identify", str(EXAMPLE), "--fix", "k=1e308"],
        ["identify", str(EXAMPLE), "--json", "/dev/null/x.json"],
        ["sensitivity", str(EXAMPLE), "--profile", "nope"],
        ["predict", "d.json", "--recording", str(EXAMPLE / "run-13.csv"), "--rate", "9e6"],
        ["predict", "d.json", "--recording", str(EXAMPLE / "run-13.csv"), "--duration", "1e-9"],
    ],
)
def test_a_bad_argument_is_told_before_jax_is_loaded(argv, tmp_path):
    (tmp_path / "d.json").write_text(json.dumps(small.diagnosis()))
    code = (
        "import sys; from tp_jax.cli import main; code = main(sys.argv[1:]);"
        "assert code == 2, code; assert 'jax' not in sys.modules"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, *argv],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr.startswith("tp-jax: ")
    assert done.stderr.count("\n") == 1


def test_more_samples_than_there_is_memory_for(monkeypatch):
    monkeypatch.setattr(arguments, "memory", lambda: 1e9)
    assert sample_count(1.0, 1e6) == 1_000_001
    with pytest.raises(InputError, match=r"take about 3 GB of memory, but this machine has 1 GB"):
        sample_count(5.0, 1e6)


def test_what_commands_know_by_heart():
    assert sensitivity.MOST_SPREAD == plausible.MOST_SPREAD


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EROFS, errno.ENAMETOOLONG])
@pytest.mark.usefixtures("any_campaign")
def test_what_the_system_refuses_is_no_fault_of_ours(number, capsys, monkeypatch):
    put(monkeypatch, "identify", failing(OSError(number, os.strerror(number), "a/file")))
    assert main(["identify", "c"]) == 2
    assert (
        capsys.readouterr().err == f"tp-jax: Cannot use the file a/file: {os.strerror(number)}.\n"
    )


@pytest.mark.parametrize("command", ["identify", "diagnose"])
def test_a_campaign_that_is_not_there(command, capsys, tmp_path):
    assert main([command, str(tmp_path / "nowhere")]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.startswith("tp-jax: ")
    assert "nowhere" in told.err
    assert told.err.count("\n") == 1


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("", "is not JSON"),
        ("[1, 2]", "is not a diagnosis"),
        ('{"schema": "tp-jax/identify/1"}', "is not a diagnosis"),
        ('{"schema": "tp-jax/diagnosis/1"}', "fits"),
        ("\xff\xfe", "is not JSON"),
    ],
)
def test_what_is_no_diagnosis(text, part, capsys, tmp_path):
    path = tmp_path / "d.json"
    path.write_text(text, encoding="latin-1")
    assert main(["predict", str(path), "--omega", "3", "--duration", "1", "--rate", "9"]) == 2
    assert part in capsys.readouterr().err


def failing(fault):
    def identify(campaign, **options):
        raise fault

    return identify


@pytest.fixture
def any_campaign(monkeypatch):
    """No campaign is read: what the library is called with is looked at instead."""
    campaign = SimpleNamespace(name="a rig/of ours", B1=1.2e-3)
    for command in ("identify", "diagnose"):
        module = importlib.import_module(f"tp_jax.cli.{command}")
        monkeypatch.setattr(module, "load", lambda args, path: campaign)
    return campaign


@pytest.mark.usefixtures("any_campaign")
def test_a_fault_of_input_from_the_library(capsys, monkeypatch):
    put(monkeypatch, "identify", failing(InputError("Fix your\nfile.")))
    assert main(["identify", "c"]) == 2
    assert capsys.readouterr().err == "tp-jax: Fix your file.\n"


@pytest.mark.usefixtures("any_campaign")
def test_a_fault_of_the_campaign_from_the_library(capsys, monkeypatch):
    fault = tp_jax.CampaignError(Path("run.csv"), "there is no column phi1", "add one", line=1)
    put(monkeypatch, "identify", failing(fault))
    assert main(["identify", "c"]) == 2
    told = capsys.readouterr().err
    assert told == "tp-jax: run.csv, line 1: there is no column phi1; add one.\n"


@pytest.mark.usefixtures("any_campaign")
def test_a_fault_of_ours(capsys, monkeypatch):
    put(monkeypatch, "identify", failing(ZeroDivisionError("float division")))
    assert main(["identify", "c"]) == 1
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert "float division" in told
    assert "--debug" in told


@pytest.mark.usefixtures("any_campaign")
@pytest.mark.parametrize("argv", [["--debug", "identify", "c"], ["identify", "c", "--debug"]])
def test_debug_shows_the_traceback(argv, capsys, monkeypatch):
    put(monkeypatch, "identify", failing(ZeroDivisionError("float division")))
    assert main(argv) == 1
    assert "Traceback" in capsys.readouterr().err


@pytest.mark.usefixtures("any_campaign")
def test_interrupted(capsys, monkeypatch):
    put(monkeypatch, "identify", failing(KeyboardInterrupt()))
    assert main(["identify", "c"]) == 130
    assert "Traceback" not in capsys.readouterr().err


def warning(*given):
    def identify(campaign, **options):
        for message, category in given:
            warnings.warn(message, category, stacklevel=1)
        raise InputError("No start came to anything.")

    return identify


MANY = [("The iteration\nis not making good progress", RuntimeWarning), ("old", FutureWarning)]


@pytest.mark.usefixtures("any_campaign")
@pytest.mark.filterwarnings("always")
def test_warnings_of_libraries_are_not_for_users(capsys, monkeypatch):
    put(monkeypatch, "identify", warning(*MANY, ("It is\nleft out.", Notice)))
    before = warnings.showwarning
    assert main(["identify", "c"]) == 2
    told = capsys.readouterr().err
    assert told == "tp-jax: It is left out.\ntp-jax: No start came to anything.\n"
    assert warnings.showwarning is before


@pytest.mark.usefixtures("any_campaign")
@pytest.mark.filterwarnings("always")
def test_debug_shows_them(capsys, monkeypatch):
    shown = []
    monkeypatch.setattr(warnings, "showwarning", lambda *given: shown.append(given[1]))
    put(monkeypatch, "identify", warning(*MANY))
    assert main(["identify", "c", "--debug"]) == 2
    assert shown == [RuntimeWarning, FutureWarning]


# simulate ------------------------------------------------------------------------------------


def test_presets_are_those_of_the_model():
    assert tp_jax.presets.names() == PRESETS


def test_both_ends_are_included():
    assert sample_count(10.0, 250.0) == 2501
    assert sample_count(0.1, 250.0) == 26


def test_simulate_writes_a_file(tmp_path, capsys):
    path = tmp_path / "new" / "run.csv"
    argv = ["simulate", "--preset", "bench", "--duration", "0.4", "--out", str(path)]
    assert main(argv) == 0
    lines = path.read_text().split("\n")
    assert lines[0] == "t,phi1,phi2"
    rows = np.loadtxt(path, delimiter=",", skiprows=1)
    assert rows.shape == (101, 3)
    assert rows[0].tolist() == [0.0, 0.0, 0.0]
    assert rows[-1, 0] == 0.4
    told = capsys.readouterr()
    assert str(path) in told.out
    assert told.err == ""
    assert [entry.name for entry in path.parent.iterdir()] == ["run.csv"]

    # 17 digits give back the very numbers
    motion = tp_jax.simulate(tp_jax.presets.get("bench"), np.linspace(0.0, 0.4, 101))
    np.testing.assert_array_equal(rows[:, 1], np.asarray(motion.phi1))
    np.testing.assert_array_equal(rows[:, 2], np.asarray(motion.phi2))

    assert main([*argv, "--quiet"]) == 0  # replaces the file, and says nothing
    assert capsys.readouterr().out == ""

    assert main(argv[:-2]) == 0  # the same to standard output
    assert capsys.readouterr().out == path.read_text()


def test_simulate_draws(tmp_path, capsys):
    pytest.importorskip("matplotlib")
    path = tmp_path / "run.png"
    assert main(["simulate", "--preset", "bench", "--duration", "0.4", "--plot", str(path)]) == 0
    assert path.read_bytes().startswith(b"\x89PNG")
    assert capsys.readouterr().out == f"Wrote {path}\n"


# identify, diagnose, predict: what the library is asked, and what is made of its answer ---------


def answering(called, result, summary="a table"):
    def ask(*arguments, **options):
        called.append((arguments, options))
        return SimpleNamespace(to_dict=lambda: result, summary=lambda: summary)

    return ask


def test_identify(any_campaign, capsys, monkeypatch, tmp_path):
    called: list = []
    result = {"schema": "tp-jax/identify/1", "objective": np.float64(np.nan), "n": np.arange(2)}
    put(monkeypatch, "identify", answering(called, result))
    argv = ["identify", "c", "--model", "paper", "--method", "nelder-mead", "--starts", "3"]
    argv += ["--fix", "k=0.5", "--fix", "Ts1=1e-3", "--bound", "A=0.1:2", "--seed", "7"]

    path = tmp_path / "r.json"
    assert main([*argv, "--json", str(path)]) == 0
    ((campaign,), options) = called[0]
    assert campaign is any_campaign
    assert callable(options.pop("progress"))
    assert options.pop("checkpoint") == Path("a rig-of ours-identification/starts.json")
    assert options == {
        "model": "paper",
        "method": "nelder-mead",
        "starts": 3,
        "fix": {"k": 0.5, "Ts1": 1e-3},
        "bound": {"A": (0.1, 2.0)},
        "seed": 7,
    }
    expected = {"schema": "tp-jax/identify/1", "objective": None, "n": [0, 1]}
    assert json.loads(path.read_text()) == expected
    assert capsys.readouterr().out == "a table\n"

    assert main([*argv, "--json", "-"]) == 0
    told = capsys.readouterr()
    assert json.loads(told.out) == expected
    assert told.err == ""

    assert main([*argv, "--quiet"]) == 0
    assert capsys.readouterr().out == ""

    assert main([*argv, "--json", str(tmp_path)]) == 2
    assert "it is a folder" in capsys.readouterr().err
    assert len(called) == 3  # told before the work rather than after it


def test_diagnose(any_campaign, capsys, monkeypatch, tmp_path):
    called: list = []
    result = {"schema": "tp-jax/diagnosis/1", "gap": {"after": float("inf")}}
    put(monkeypatch, "diagnose", answering(called, result))
    asked = []

    def write_report(given, path, *, figures, day):
        asked.append(figures)
        assert day == date.today()
        Path(path).write_text(str(given))

    html = SimpleNamespace(write_report=write_report)
    monkeypatch.setitem(sys.modules, "tp_jax.report.html", html)
    monkeypatch.chdir(tmp_path)

    assert main(["diagnose", "c", "--seed", "3"]) == 0
    ((campaign,), options) = called[0]
    assert campaign is any_campaign
    assert options["seed"] == 3
    folder = tmp_path / "a rig-of ours-diagnosis"
    assert json.loads((folder / "diagnosis.json").read_text())["gap"] == {"after": None}
    assert "None" in (folder / "report.html").read_text()
    told = capsys.readouterr().out
    assert told.startswith("There is no verdict\n")
    assert told.rstrip().split("\n")[-1].endswith("a rig-of ours-diagnosis/report.html")

    assert main(["diagnose", "c", "--out", "there", "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["schema"] == "tp-jax/diagnosis/1"
    assert sorted(entry.name for entry in Path("there").iterdir()) == [
        "diagnosis.json",
        "report.html",
    ]

    assert main(["diagnose", "c", "--figures", "--quiet"]) == 0
    assert asked == [False, False, True]

    Path("taken").write_text("")
    assert main(["diagnose", "c", "--out", "taken"]) == 2
    assert "taken" in capsys.readouterr().err
    assert len(called) == 3  # told before the work rather than after it


def test_a_wrong_option_takes_no_kept_fits_away(tmp_path, capsys):
    out = tmp_path / "out"
    out.mkdir()
    (out / "fits.json").write_text("{}")
    command = ["diagnose", str(EXAMPLE), "--out", str(out), "--without", "contact_stribek"]
    assert main(command) == 2
    assert "contact_stribek" in capsys.readouterr().err
    assert (out / "fits.json").read_text() == "{}"


@pytest.mark.parametrize(
    ("name", "folder"),
    [
        ("case-02", "case-02-diagnosis"),
        ("../up", "-up-diagnosis"),
        ("", "campaign-diagnosis"),
        ("..", "campaign-diagnosis"),
    ],
)
def test_the_folder_stays_here(name, folder):
    assert default_folder(name) == Path(folder)


def test_the_example_is_a_campaign():
    campaign = tp_jax.load_campaign(EXAMPLE)
    assert campaign.name == "case-02"


def test_the_example_is_the_shared_one(shared):
    there = shared / "examples" / "case-02"
    names = {path.name for path in there.iterdir()} - {"key.json"}
    assert {path.name for path in EXAMPLE.iterdir()} == names
    for name in names:
        assert (EXAMPLE / name).read_bytes() == (there / name).read_bytes()


def test_predict(capsys, monkeypatch, tmp_path):
    called: list = []

    def predict(diagnosis, **options):
        called.append((diagnosis, options))
        t = np.array([0.0, 0.1])
        return SimpleNamespace(t=t, phi1=t / 3, phi2=None if options["phi1"] else t)

    put(monkeypatch, "predict", predict)
    path = tmp_path / "diagnosis.json"
    path.write_text(json.dumps(small.diagnosis()))
    argv = ["predict", str(path), "--duration", "0.1", "--rate", "10"]

    assert main([*argv, "--phi1", "-0.5", "--model", "before"]) == 0
    assert capsys.readouterr().out.split("\n")[0] == "t,phi1"
    diagnosis, options = called[0]
    assert diagnosis == small.diagnosis()
    assert options == {
        "omega": None,
        "phi1": -0.5,
        "recording": None,
        "duration": 0.1,
        "rate": 10.0,
        "model": "before",
    }

    out = tmp_path / "run.csv"
    assert main(["predict", str(path), "--recording", "r.csv", "--out", str(out)]) == 0
    assert capsys.readouterr().out == f"Wrote {out}\n"
    assert out.read_text().split("\n")[0] == "t,phi1,phi2"
    assert called[1][1]["recording"] == "r.csv"
    assert called[1][1]["duration"] is None


def test_a_run_that_does_not_end_is_our_fault(capsys, monkeypatch, tmp_path):
    t = np.array([0.0, 0.1])
    motion = SimpleNamespace(t=t, phi1=np.array([0.0, np.inf]), phi2=t)
    put(monkeypatch, "predict", lambda diagnosis, **options: motion)
    path = tmp_path / "diagnosis.json"
    path.write_text(json.dumps(small.diagnosis()))
    argv = ["predict", str(path), "--omega", "5", "--duration", "0.1", "--rate", "10"]
    assert main(argv) == 1
    told = capsys.readouterr()
    assert told.out == ""
    assert "did not reach the end" in told.err
