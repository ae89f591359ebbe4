"""Files appear whole or not at all; JSON has no NaN."""

import json
import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tp_jax.cli.output import json_text, plain, ready, replaced, write_json, write_text
from tp_jax.errors import InputError


def test_what_fails_leaves_the_old_file(tmp_path):
    path = tmp_path / "r.txt"
    write_text(path, "old")
    with pytest.raises(ZeroDivisionError), replaced(path) as part:  # noqa: PT012
        part.write_text("half")
        raise ZeroDivisionError
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_link_keeps_pointing(tmp_path):
    path, link = tmp_path / "r.txt", tmp_path / "link.txt"
    write_text(path, "old")
    link.symlink_to(path)
    write_text(link, "new")
    assert link.is_symlink()
    assert path.read_text() == "new"


def test_what_is_no_file_is_written_to():
    write_text(os.devnull, "gone")
    assert not Path(os.devnull).is_file()


def test_rights_are_those_of_a_new_file(tmp_path):
    plainly = tmp_path / "plainly"
    plainly.write_text("")
    write_text(tmp_path / "replaced", "")
    assert (tmp_path / "replaced").stat().st_mode == plainly.stat().st_mode


@pytest.mark.parametrize("target", [".", "file/below"])
def test_places_that_cannot_be_written(target, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="Cannot write"):
        write_text(tmp_path / target, "text")


@pytest.mark.parametrize("target", [".", "file/below"])
def test_places_that_cannot_be_written_are_seen_before(target, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="Cannot"):
        ready(tmp_path / target)


def test_places_that_can_be_written(tmp_path):
    ready(None, "-", os.devnull, tmp_path / "new" / "r.json")
    assert list((tmp_path / "new").iterdir()) == []


def test_a_fault_of_another_file_is_passed_on(tmp_path):
    with pytest.raises(FileNotFoundError), replaced(tmp_path / "r.txt"):
        Path(tmp_path, "template").read_text()


def test_plain_values():
    given = {
        "nan": float("nan"),
        "inf": np.float32("inf"),
        "array": np.array([[1.0, -np.inf]]),
        "whole": np.int64(3),
        "flag": np.bool_(True),
        "path": Path("a"),
        "tuple": (1, None, "ω"),
        4: {"b", "a"},
    }
    assert plain(given) == {
        "nan": None,
        "inf": None,
        "array": [[1.0, None]],
        "whole": 3,
        "flag": True,
        "path": "a",
        "tuple": [1, None, "ω"],
        "4": ["a", "b"],
    }
    with pytest.raises(TypeError, match="object"):
        plain(object())


def test_json_of_jax_arrays():
    import jax.numpy as jnp

    assert json.loads(json_text({"x": jnp.array([0.1, jnp.nan])})) == {"x": [0.1, None]}


def test_json_to_standard_output(capsys):
    write_json("-", {"x": 1})
    assert json.loads(capsys.readouterr().out) == {"x": 1}


@given(st.recursive(st.floats() | st.text() | st.none(), st.lists, max_leaves=9))
def test_json_never_holds_what_json_does_not_know(value):
    def refuse(constant):
        raise AssertionError(constant)

    json.loads(json_text({"x": value}), parse_constant=refuse)


def test_no_result_replaces_what_is_read(tmp_path):
    """Nor a campaign.toml, whoever reads it."""
    read, link = tmp_path / "cal.csv", tmp_path / "link.csv"
    read.write_text("phi1,V\n")
    link.symlink_to(read)
    campaign = tmp_path / "campaign.toml"
    campaign.write_text("")
    for target, inputs in ((read, [read]), (link, [read]), (read, [link]), (campaign, [])):
        with pytest.raises(InputError, match="would replace"):
            ready(target, inputs=inputs)
    ready(tmp_path / "new.json", inputs=[read])


def test_a_name_that_is_no_text_can_be_written(tmp_path):
    """As of a file that was named on another system."""
    name = os.fsdecode(b"lauf\xe4.csv")
    write_json(tmp_path / "a.json", {"file": name})
    assert json.loads((tmp_path / "a.json").read_text())["file"] == name
