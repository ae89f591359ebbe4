"""Readings of a sensor slower than the file: how many really come, and each of them kept once."""

import numpy as np
import pytest

from tests.following import follow
from tests.made_runs import NOISE, OMEGA, made_run, write_rows, write_toml
from tp_jax.checks import check
from tp_jax.checks.proposal import propose
from tp_jax.errors import Notice
from tp_jax.recordings import load_campaign
from tp_jax.recordings.held import held

RATE, N = 250.0, 2500


def slow(rate: float, late: float = 0.0, quantum: float = 0.0, seed: int = 0):
    """Rows at 250 a second of readings that come less often, and those readings themselves."""
    t, a, b = made_run(n=round(N * rate / RATE) + 2, rate=rate, seed=seed)
    if quantum:
        a, b = (np.round(x / quantum) * quantum for x in (a, b))
    which = np.floor(np.arange(N) * rate / RATE + late + 1e-9).astype(int)
    return (np.arange(N) / RATE, a[which], b[which]), (t - late / rate, a, b)


def written(folder, columns, name="a.csv"):
    write_rows(folder / name, "t,phi1,phi2", *columns)
    write_toml(folder, {name: OMEGA})
    return folder


def told(folder) -> str:
    (wrong,) = check(folder).wrong
    return wrong.sentence


def loaded(folder):
    with pytest.warns(Notice, match="readings come"):
        (recording,) = load_campaign(folder).recordings
    return recording


@pytest.mark.parametrize("late", [0.0, 0.37], ids=["from its first", "from within"])
@pytest.mark.parametrize("rate", [50.0, 62.5, 80.0, 100.0, 125.0, 150.0, 200.0, 240.0, 30.0, 12.5])
def test_held_readings_are_told_and_kept_once(rate, late, tmp_path):
    rows, (t, a, _) = slow(rate, late)
    sentence = told(written(tmp_path, rows))
    assert f"phi1 and phi2 come {rate:g} times a second" in sentence
    assert f"keep one of {RATE / rate:.4g} rows" in sentence
    follow(tmp_path, sentence)
    assert check(tmp_path).wrong == ()
    recording = loaded(tmp_path)
    off = 0 if abs(recording.phi1[0] - a[0]) < 1e-8 else 1  # the first may be of any age
    n = recording.n
    assert n >= N * rate / RATE - 2
    np.testing.assert_allclose(recording.phi1, a[off : off + n], atol=1e-8)
    age = recording.t - t[off : off + n]  # a row at most, and the same for all
    np.testing.assert_allclose(age, age.mean(), atol=2e-5)
    assert -2e-5 < age.mean() < 1.0 / RATE


@pytest.mark.parametrize("rate", [50.0, 80.0, 100.0])
@pytest.mark.parametrize("which", ["phi1", "phi2"])
def test_one_of_the_two_angles(rate, which, tmp_path):
    (t, a, b), _ = slow(rate)
    _, fresh_a, fresh_b = made_run(seed=5)
    columns = (t, a, fresh_b) if which == "phi1" else (t, fresh_a, b)
    sentence = told(written(tmp_path, columns))
    assert f"readings of {which} come {rate:g} times a second" in sentence
    follow(tmp_path, sentence)
    recording = loaded(tmp_path)
    clean = {"phi1": made_run(n=40001, rate=4000.0)[1], "phi2": made_run(n=40001, rate=4000.0)[2]}
    for name, angle in recording.channels.items():
        truth = np.interp(recording.t, np.arange(40001) / 4000.0, clean[name])
        assert np.std(angle - truth) < 2.0 * NOISE  # that of both, and no delay


def test_both_angles_with_rates_of_their_own(tmp_path):
    (t, a, _), _ = slow(100.0)
    (_, _, b), _ = slow(62.5, seed=3)
    sentence = told(written(tmp_path, (t, a, b)))
    assert "62.5 times a second" in sentence
    follow(tmp_path, sentence)
    recording = loaded(tmp_path)
    assert recording.n == pytest.approx(625, abs=1)
    assert check(tmp_path).wrong == ()


@pytest.mark.parametrize("rate", [50.0, 80.0, 100.0, 150.0, 200.0])
def test_a_coarse_encoder_that_is_held(rate, tmp_path):
    rows, (_, a, _) = slow(rate, quantum=2.0 * np.pi / 4096)
    sentence = told(written(tmp_path, rows))
    assert f"come {rate:g} times a second" in sentence
    follow(tmp_path, sentence)
    recording = loaded(tmp_path)
    assert recording.n == pytest.approx(N * rate / RATE, abs=2)
    assert min(np.abs(recording.phi1[:200] - a[i : i + 200]).max() for i in (0, 1)) < 1e-7


def test_files_with_other_rates_and_one_that_is_as_it_should_be(tmp_path):
    for name, rate in {"a.csv": 50.0, "b.csv": 50.0, "c.csv": 100.0}.items():
        written(tmp_path, slow(rate)[0], name)
    write_rows(tmp_path / "d.csv", "t,phi1,phi2", *made_run())
    write_toml(tmp_path, dict.fromkeys(("a.csv", "b.csv", "c.csv", "d.csv"), OMEGA))
    first, second = (each.sentence for each in check(tmp_path).wrong)
    assert first.startswith("a.csv, b.csv: ")
    assert second.startswith("c.csv: ")
    follow(tmp_path, first)
    assert check(tmp_path).wrong == ()
    with pytest.warns(Notice):
        sizes = [each.n for each in load_campaign(tmp_path).recordings]
    assert sizes == [500, 500, 1000, 2500]


def test_the_rate_that_the_rig_states_is_that_of_the_rows(tmp_path):
    folder = written(tmp_path, slow(50.0)[0])
    toml = folder / "campaign.toml"
    toml.write_text(toml.read_text().replace("[[rec", "[rig]\nsample_rate = 250.0\n[[rec", 1))
    follow(folder, told(folder))
    assert check(folder).wrong == ()


@pytest.mark.parametrize("rate", [50.0, 100.0, 125.0, 200.0])
def test_steps_of_held_readings_are_no_noise_of_another_unit(rate, tmp_path):
    """In one run the rider sticks: in the others each step is as large as its motion."""
    for i, name in enumerate(("a.csv", "b.csv", "c.csv")):
        t, a, b = slow(rate, seed=i)[0]
        rest = 0.02 * b + 0.0 if name == "a.csv" else b
        write_rows(tmp_path / name, "t,phi1,phi2", t, a, rest)
    write_toml(tmp_path, dict.fromkeys(("a.csv", "b.csv", "c.csv"), OMEGA))
    assert [each.kind for each in check(tmp_path).wrong] == ["held"]


def test_init_writes_it(tmp_path):
    written(tmp_path, slow(50.0)[0])
    (tmp_path / "campaign.toml").unlink()
    text, notes = propose(tmp_path)
    assert "held = true" in text
    assert "one of 5 rows was kept" in notes[0]
    (tmp_path / "campaign.toml").write_text(text)
    assert check(tmp_path).wrong == ()


T = np.arange(N) / RATE
MOTIONS = {
    "a swing": 0.4 * np.sin(OMEGA * T),
    "a swing of five a second": 0.4 * np.sin(2.0 * np.pi * 5.0 * T),
    "a fast one": 0.05 * np.sin(2.0 * np.pi * 25.0 * T),
    "at rest": 0.0 * T,
    "a decay": 0.4 * np.exp(-0.5 * T) * np.sin(18.0 * T),
    "winding": 30.0 * T,
    "winding slowly": 0.1 * T,
    "winding and swinging": T + 0.2 * np.sin(2.0 * np.pi * 5.0 * T),
    "sticking": np.clip(0.4 * np.sin(OMEGA * T), -0.2, 0.2),
}


@pytest.mark.parametrize("what", MOTIONS)
@pytest.mark.parametrize("noise", [0.0, 1e-5, NOISE])
@pytest.mark.parametrize("quantum", [1e-9, 1e-3, 2.0 * np.pi / 4096, 2.0 * np.pi / 400])
def test_a_coarse_sensor_is_no_held_one(what, noise, quantum):
    x = MOTIONS[what] + noise * np.random.default_rng(0).standard_normal(N)
    assert held(np.round(x / quantum) * quantum) is None


def test_a_few_readings_that_are_equal_by_chance():
    x = made_run()[1].copy()
    for i in np.random.default_rng(0).choice(np.arange(1, N), 60, replace=False):
        x[i] = x[i - 1]
    assert held(x) is None
