"""tp-jax identify: what the library is asked, what is kept where, how a search is gone on with."""

import json
from pathlib import Path
from types import SimpleNamespace

import pytest

import tp_jax
from tp_jax.cli import identify as command
from tp_jax.cli import main
from tp_jax.errors import InputError

DONE = SimpleNamespace(to_dict=lambda: {"schema": "tp-jax/identify/1"}, summary=lambda: "a table")


@pytest.fixture
def asked(monkeypatch, tmp_path):
    """No campaign is read and nothing computed: the options that the library is called with."""
    calls: list[dict] = []

    def identify(campaign, **options):
        options.pop("progress")
        calls.append(options)
        kept = options.get("checkpoint")
        if kept is not None:  # as the library does after the first starts
            Path(kept).parent.mkdir(parents=True, exist_ok=True)
            Path(kept).write_text("{}")
        return DONE

    monkeypatch.setenv("TP_JAX_CACHE", "off")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(
        command, "load", lambda args, path: SimpleNamespace(name="our/rig", B1=None)
    )
    monkeypatch.setitem(vars(tp_jax), "identify", identify)
    return calls


def drawing(monkeypatch):
    """In the place of the figures, which need a result to draw."""

    def draw(result, folder):
        (folder / "waterfall.png").write_bytes(b"")
        return [folder / "waterfall.png"]

    monkeypatch.setattr(command, "_draw", draw)


def test_the_usual_is_not_passed_on(asked):
    assert main(["identify", "c"]) == 0
    assert asked == [
        {"model": "newton", "method": "least-squares", "fix": {}, "bound": {}, "seed": 0}
    ]
    assert list(Path().iterdir()) == []


def test_all_options(asked):
    argv = ["identify", "c", "--objective", "free-run", "--loss", "huber", "--noise", "fit"]
    argv += ["--sampling", "latin-hypercube", "--raw-starts", "--iterations", "9"]
    assert main(argv) == 0
    del asked[0]["model"], asked[0]["method"], asked[0]["fix"], asked[0]["bound"], asked[0]["seed"]
    assert asked[0] == {
        "objective": "free-run",
        "loss": "huber",
        "noise": "fit",
        "raw_starts": True,
        "sampling": "latin-hypercube",
        "iterations": 9,
    }


@pytest.mark.parametrize("method", command.METHODS)
def test_one_argument_swaps_the_method(asked, method):
    assert main(["identify", "c", "--method", method]) == 0
    assert asked[0]["method"] == method


def test_names_are_the_librarys():
    from tp_jax.estimation.methods import METHODS, OBJECTIVES
    from tp_jax.estimation.robust import LOSSES
    from tp_jax.estimation.starts import SAMPLINGS

    assert (command.METHODS, command.OBJECTIVES) == (METHODS, OBJECTIVES)
    assert (command.LOSSES, command.SAMPLINGS) == (LOSSES, SAMPLINGS)


def test_finished_starts_are_kept_until_the_end(asked):
    assert main(["identify", "c", "--starts", "4"]) == 0
    assert asked[0]["checkpoint"] == Path("our-rig-identification/starts.json")
    assert list(Path().iterdir()) == []  # and its folder went with it


def test_a_folder_with_more_in_it_stays(asked):
    Path("our-rig-identification").mkdir()
    Path("our-rig-identification/notes.txt").write_text("mine")
    assert main(["identify", "c", "--starts", "4"]) == 0
    assert [p.name for p in Path("our-rig-identification").iterdir()] == ["notes.txt"]


def test_out_keeps_starts_and_figures(asked, monkeypatch, capsys):
    drawing(monkeypatch)
    assert main(["identify", "c", "--out", "there", "--starts", "2"]) == 0
    assert asked[0]["checkpoint"] == Path("there/starts.json")
    assert sorted(p.name for p in Path("there").iterdir()) == ["starts.json", "waterfall.png"]
    assert capsys.readouterr().out == f"a table\nWrote {Path('there/waterfall.png')}\n"
    assert main(["identify", "c", "--out", "there", "--starts", "2", "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out) == {"schema": "tp-jax/identify/1"}


def test_resume_asks_for_the_same_file(asked):
    assert main(["identify", "c", "--starts", "4", "--resume"]) == 0
    assert asked[0]["resume"] is True
    assert asked[0]["checkpoint"] == Path("our-rig-identification/starts.json")


def test_ctrl_c_says_how_to_go_on(asked, monkeypatch, capsys):
    from tp_jax.estimation.multistart import Interrupted

    def identify(campaign, **options):
        raise Interrupted(8, 16, str(options["checkpoint"]))

    monkeypatch.setitem(vars(tp_jax), "identify", identify)
    assert main(["identify", "c", "--starts", "16"]) == 130
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err == (
        "tp-jax: Interrupted after 8 of 16 starts, which are kept in "
        f"{Path('our-rig-identification/starts.json')}; the same command with --resume goes on.\n"
    )


def test_a_resume_that_does_not_match_is_bad_input(asked, monkeypatch, capsys):
    def identify(campaign, **options):
        raise InputError("Cannot resume from starts.json, which is of another search.")

    monkeypatch.setitem(vars(tp_jax), "identify", identify)
    assert main(["identify", "c", "--starts", "16", "--resume"]) == 2
    assert capsys.readouterr().err.count("\n") == 1
