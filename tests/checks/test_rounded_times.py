"""Times with few decimals: rows that came evenly are put where they came, and it is said."""

import numpy as np
import pytest

from tests.following import follow
from tests.made_runs import OMEGA, made_run, write_rows, write_toml
from tp_jax.checks import check
from tp_jax.checks.proposal import propose
from tp_jax.errors import Notice
from tp_jax.recordings import CampaignError, Recording, load_campaign
from tp_jax.recordings.rounding import made_even

T, A, B = made_run()


def written(folder, cells, a=A, b=B, omega=OMEGA):
    write_rows(folder / "a.csv", "t,phi1,phi2", cells, a, b)
    write_toml(folder, {"a.csv": omega})
    return folder


def note(folder) -> str:
    checked = check(folder)
    assert checked.wrong == ()
    mended = [each.sentence for each in checked.findings if each.level == "mended"]
    (rounded,) = [each for each in mended if "counted from the first row" not in each]
    return rounded


# samples a second, decimals, and the greatest error of a time that is left, but for one of all [s]
KINDS = [
    (250.0, 2, 1e-5),
    (200.0, 2, 2e-4),
    (333.0, 2, 1e-4),
    (60.0, 2, 1e-5),
    (128.0, 2, 1e-4),
    (250.0, 1, 1e-4),
    (50.0, 1, 1e-4),
    (2000.0, 3, 2e-5),
    (1500.0, 3, 1e-5),
    (300.0, 3, 1e-5),
    (240.7, 3, 1e-5),
    (250.0, 0, 2e-3),
]


@pytest.mark.parametrize(("rate", "decimals", "within"), KINDS)
def test_rounded_times_are_made_even(rate, decimals, within, tmp_path):
    t, a, b = made_run(rate=rate)
    told = note(written(tmp_path, [f"{x:.{decimals}f}" for x in t], a, b))
    assert f"times are rounded to {10.0**-decimals:g} s" in told
    with pytest.warns(Notice, match="times are rounded"):
        (recording,) = load_campaign(tmp_path).recordings
    assert recording.n == t.size  # no row is left out
    off = recording.t - t
    assert abs(off.mean()) < 0.3 * 10.0**-decimals
    np.testing.assert_allclose(off, off.mean(), atol=within)
    (tmp_path / "campaign.toml").unlink()
    assert "forced = true" in propose(tmp_path)[0]


def rows_kept(which: str) -> np.ndarray:
    keep = np.ones(T.size, dtype=bool)
    if which == "a gap":
        keep[700:1300] = False
    elif which == "five rows":
        keep[900:905] = False
    else:
        keep[np.random.default_rng(3).choice(np.arange(50, 2450), 8, replace=False)] = False
    return keep


@pytest.mark.parametrize(
    ("which", "within"), [("a gap", 2e-3), ("five rows", 2e-3), ("single rows", 8.1e-3)]
)
def test_where_rows_are_missing(which, within, tmp_path):
    """Which row of two or three of the same time is missing, nobody can tell."""
    keep = rows_kept(which)
    told = note(written(tmp_path, [f"{x:.2f}" for x in T[keep]], A[keep], B[keep]))
    assert "rounded to 0.01 s" in told
    with pytest.warns(Notice):
        (recording,) = load_campaign(tmp_path).recordings
    np.testing.assert_allclose(recording.t, T[keep], atol=within)
    assert np.mean(np.abs(recording.t - T[keep]) < 1.5e-3) > 0.8
    assert np.all(np.diff(recording.t) > 1e-3)


@pytest.mark.parametrize(
    "style", ["floor", "started late", "since 1970", "in ms", "whole seconds of a clock"]
)
def test_other_ways_to_round(style, tmp_path):
    cells, form, within = {
        "floor": ([f"{x:.2f}" for x in np.floor(100.0 * T + 1e-9) / 100.0], "", 1e-3),
        "started late": ([f"{x + 17.321:.2f}" for x in T], "", 3e-4),
        "since 1970": ([f"{x + 1764151200.0:.2f}" for x in T], "", 1e-4),
        "in ms": (
            [f"{10.0 * round(100.0 * x):.0f}" for x in T],
            '[format.columns]\nt = { unit = "ms" }',
            1e-4,
        ),
        "whole seconds of a clock": (
            [f"10:15:{int(x) + 30:02d}" for x in T],
            "",
            2e-3,
        ),
    }[style]
    write_rows(tmp_path / "a.csv", "t,phi1,phi2", cells, A, B)
    write_toml(tmp_path, {"a.csv": OMEGA}, form)
    assert "times are rounded" in note(tmp_path)
    with pytest.warns(Notice):
        (recording,) = load_campaign(tmp_path).recordings
    off = recording.t - T
    np.testing.assert_allclose(off, off.mean(), atol=within)


def test_a_clock_that_trembles_a_little(tmp_path):
    t = T + np.random.default_rng(0).uniform(-4e-4, 4e-4, T.size)
    note(written(tmp_path, [f"{x:.2f}" for x in t]))
    with pytest.warns(Notice):
        (recording,) = load_campaign(tmp_path).recordings
    np.testing.assert_allclose(recording.t, T, atol=1e-3)


def test_rows_that_do_not_come_evenly_are_not_made_even(tmp_path):
    t = np.sort(np.random.default_rng(0).uniform(0.0, 10.0, T.size))
    folder = written(tmp_path, [f"{x:.2f}" for x in t])
    (wrong,) = check(folder).wrong
    assert "times are rounded to 0.01 s" in wrong.sentence
    assert "write the times with more decimals" in wrong.sentence
    assert "remove" not in wrong.sentence


@pytest.mark.parametrize("times", [2, 3, 5])
def test_rows_that_were_written_often_are_no_rounded_times(times, tmp_path):
    t, a, b = (np.repeat(each[:600], times) for each in (T, A, B))
    (wrong,) = check(written(tmp_path, [f"{x:.3f}" for x in t], a, b)).wrong
    assert "rounded" not in wrong.sentence
    assert "repeated" in wrong.sentence
    assert f"keep one of {times} rows" in wrong.sentence
    follow(tmp_path, wrong.sentence)
    assert check(tmp_path).wrong == ()
    with pytest.warns(Notice, match=f"600 of {600 * times} rows were kept"):
        (recording,) = load_campaign(tmp_path).recordings
    np.testing.assert_allclose(recording.t, T[:600], atol=1e-9)
    np.testing.assert_allclose(recording.phi1, A[:600], atol=1e-8)


EXACT = {
    "even": T,
    "a time that is wrong": np.where(np.arange(T.size) == 700, T - 1e-3, T),
    "fine decimals": np.round(T + np.random.default_rng(0).uniform(0.0, 1e-3, T.size), 6),
    "two rates": np.concatenate([T[:1250], 5.0 + 0.002 * np.arange(1250)]),
    "a few rows lost": np.delete(T, [100, 500, 501, 900, 1700]),
    "three rows lost": np.delete(T, [600, 1250, 1900]),
    "many rows lost": np.delete(T, np.random.default_rng(1).choice(2500, 200, replace=False)),
    "one decimal, and even": 0.1 * np.arange(500),
}


@pytest.mark.parametrize("what", EXACT)
def test_times_that_are_right_stay_bit_for_bit(what):
    t = EXACT[what]
    assert made_even(t, np.zeros(t.size - 1, dtype=bool)) is None


def test_arrays_too():
    recording = Recording.from_arrays(np.round(T, 2), A, B, omega=OMEGA)
    np.testing.assert_allclose(recording.t, T, atol=1e-5)
    assert "times are rounded to 0.01 s" in recording.notes[0]
    with pytest.raises(CampaignError, match="is repeated"):
        Recording.from_arrays(np.where(np.arange(T.size) == 7, T[6], T), A, B, omega=OMEGA)


def test_a_step_that_no_clock_can_tell_is_none():
    """Differences divided by it overflowed, and the noise had no level."""
    t = T.copy()
    t[1] = 1e-320
    with pytest.raises(CampaignError, match="is repeated"):
        Recording.from_arrays(t, A, B, omega=OMEGA)
