"""What a search has done survives in its file."""

import json

import numpy as np
import pytest

from tp_jax.errors import InputError
from tp_jax.estimation.checkpoint import Checkpoint
from tp_jax.estimation.outcome import Outcome

KEY = {"data": {"a.csv": "12"}, "seed": 0, "bounds": {"k": (1.0, 2.0)}}


def test_goes_on_from_what_was_kept(tmp_path):
    path = tmp_path / "new" / "starts.json"
    first = Checkpoint(path, KEY)
    kept = {
        "start 0": Outcome.failed(np.array([0.1, 1e-300]), "Not.").to_dict(),
        "start 1": Outcome.failed(np.array([1.0 / 3.0]), "Not.").to_dict(),
    }
    for name, each in kept.items():
        first.put({name: each})
    again = Checkpoint(path, KEY)
    assert again.resume() == 2
    assert again.done == kept
    assert [entry.name for entry in path.parent.iterdir()] == ["starts.json"]


@pytest.mark.parametrize(
    ("change", "part"),
    [
        ({"seed": 1}, "it differs in seed"),
        ({"data": {"a.csv": "13"}, "seed": 2}, "it differs in data, seed"),
    ],
)
def test_another_search_is_refused(tmp_path, change, part):
    path = tmp_path / "starts.json"
    Checkpoint(path, KEY).put({})
    with pytest.raises(InputError, match=part) as refused:
        Checkpoint(path, KEY | change).resume()
    assert str(refused.value).count(".") - str(path).count(".") == 1  # one sentence


@pytest.mark.parametrize(
    ("text", "part"),
    [
        (None, "nothing to resume"),
        ("{", "is not JSON"),
        ("[]", "is not a file of starts"),
        ("{}", "is not a file of starts"),
        ('{"schema": "tp-jax/starts/0"}', "of the version tp-jax/starts/0"),
        ('{"schema": "tp-jax/starts/1", "sha256": "", "key": {}}', "sha256|done"),
    ],
)
def test_what_is_no_checkpoint(tmp_path, text, part):
    path = tmp_path / "starts.json"
    if text is not None:
        path.write_text(text)
    with pytest.raises(InputError, match=part):
        Checkpoint(path, KEY).resume()


def test_a_failed_write_leaves_what_was_there(tmp_path):
    path = tmp_path / "starts.json"
    kept = Checkpoint(path, KEY)
    kept.put({"start 0": {}})
    before = path.read_text()
    with pytest.raises(TypeError):
        kept.put({"start 1": object()})
    assert path.read_text() == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["starts.json"]


def test_outcomes_survive_to_the_last_digit():
    rng = np.random.default_rng(0)
    made = Outcome(
        rng.normal(size=3),
        1.0 / 3.0,
        np.inf,
        rng.normal(size=(3, 3)),
        7,
        True,
        "Done.",
        np.inf,
        rng.normal(size=(5, 4)),
    )
    back = Outcome.from_dict(json.loads(json.dumps(made.to_dict(), allow_nan=False)))
    for name in ("x", "information", "states"):
        np.testing.assert_array_equal(getattr(back, name), getattr(made, name))
    assert (back.cost, back.chi2_dof, back.objective) == (1.0 / 3.0, np.inf, np.inf)
    assert (back.evaluations, back.converged, back.message) == (7, True, "Done.")


def test_numbers_that_are_none_are_kept():
    made = Outcome(
        np.ones(2), 1e60, 1.0, np.eye(2), 7, False, "Left.", 1e60, np.full((3, 4), np.nan)
    )
    back = Outcome.from_dict(json.loads(json.dumps(made.to_dict(), allow_nan=False)))
    np.testing.assert_array_equal(back.states, made.states)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("x", [1.0]),
        ("x", ["a", "b"]),
        ("x", [[1.0], [1.0, 2.0]]),
        ("information", [1.0, 2.0]),
        ("states", [1.0]),
        ("x", [1.0, 10**400]),
    ],
)
def test_outcomes_that_were_edited(name, value):
    stored = Outcome.failed(np.ones(2), "Not.").to_dict() | {name: value}
    with pytest.raises(InputError, match="has other numbers than it ended with"):
        Outcome.from_dict(stored)


def test_starts_that_were_changed_are_refused(tmp_path):
    path = tmp_path / "starts.json"
    Checkpoint(path, KEY).put({"start 0": Outcome.failed(np.array([0.25, 2.0]), "Not.").to_dict()})
    path.write_text(path.read_text().replace("0.25", "0.26"))
    with pytest.raises(InputError, match="were changed after they ended"):
        Checkpoint(path, KEY).resume()
