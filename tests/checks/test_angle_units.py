"""Angles of one file, or of one column, in another unit: named, with a mend that works."""

import numpy as np
import pytest

from tests.following import follow
from tests.made_runs import made_run, write_rows, write_toml
from tp_jax.checks import check
from tp_jax.recordings import load_campaign

OMEGAS = {"w8.csv": 8.0, "w13.csv": 13.09, "w18.csv": 18.0}
RIDERS = {"w8.csv": 0.0, "w13.csv": 1.0, "w18.csv": 1.0}  # it sticks in the first
PER_RAD = {
    "deg": 180.0 / np.pi,
    "gon": 200.0 / np.pi,
    "mrad": 1000.0,
    "turn": 0.5 / np.pi,
    "rad": 1.0,
}
NAMES = {"deg": "degrees", "gon": "gons", "mrad": "milliradians", "turn": "turns", "rad": "radians"}


def runs(seed: int = 0, quantum: float = 0.0) -> dict[str, list[np.ndarray]]:
    out = {}
    for i, (name, omega) in enumerate(OMEGAS.items()):
        t, a, b = made_run(omega=omega, seed=seed + i)
        rest = 1e-3 * np.random.default_rng(seed + 10 + i).standard_normal(t.size)
        b = b if RIDERS[name] else rest
        out[name] = [t, *(np.round(x / quantum) * quantum if quantum else x for x in (a, b))]
    return out


def write(folder, made, omegas=None, form=""):
    for name, columns in made.items():
        write_rows(folder / name, "t,phi1,phi2", *columns)
    write_toml(folder, omegas or {name: OMEGAS.get(name, 13.09) for name in made}, form)
    return folder


def mended(folder, right, most: int = 3) -> list[str]:
    """The campaign reads as the runs do, once what is said has been followed; what was said."""
    told = []
    for _ in range(most):
        wrong = check(folder).wrong
        if not wrong:
            break
        told.append(wrong[0].sentence)
        follow(folder, told[-1])
    assert check(folder).wrong == ()
    for recording in load_campaign(folder).recordings:
        for values, true in zip(
            recording.channels.values(), right[recording.name][1:], strict=True
        ):
            np.testing.assert_allclose(values, true, atol=1e-6)
    return told


@pytest.mark.parametrize("unit", ["deg", "gon", "mrad", "turn"])
@pytest.mark.parametrize("spoilt", ["phi1", "phi2", "both"])
@pytest.mark.parametrize("name", ["w13.csv", "w18.csv"])
def test_one_file_in_another_unit(unit, spoilt, name, tmp_path):
    right, made = runs(), runs()
    for channel in (1, 2) if spoilt == "both" else (int(spoilt[-1]),):
        made[name][channel] = made[name][channel] * PER_RAD[unit]
    write(tmp_path, made)
    (wrong,) = check(tmp_path).wrong
    assert name in wrong.sentence
    assert NAMES[unit] in wrong.sentence
    assert not any(other in wrong.sentence for other in OMEGAS if other != name)
    assert not any(other in each.sentence for each in check(tmp_path).doubtful for other in OMEGAS)
    mended(tmp_path, right)


@pytest.mark.parametrize("unit", ["deg", "mrad"])
def test_the_file_in_which_the_rider_sticks(unit, tmp_path):
    right, made = runs(), runs()
    made["w8.csv"][2] = made["w8.csv"][2] * PER_RAD[unit]
    (told,) = mended(write(tmp_path, made), right)
    assert told.startswith("w8.csv: phi2 is in")


def test_a_decay_in_degrees(tmp_path):
    right = runs()
    t = right["w8.csv"][0]
    random = np.random.default_rng(7)
    swing = 0.1 * np.exp(-0.3 * t) * np.cos(18.0 * t)
    right["decay.csv"] = [t, *(swing * s + 1e-3 * random.standard_normal(t.size) for s in (1, 0.3))]
    made = dict(right)
    made["decay.csv"] = [t, *(np.degrees(x) for x in right["decay.csv"][1:])]
    write(tmp_path, made)
    text = (tmp_path / "campaign.toml").read_text()
    (tmp_path / "campaign.toml").write_text(
        text.replace('file = "decay.csv"\nomega = 13.09', 'file = "decay.csv"\nforced = false')
    )
    (told,) = mended(tmp_path, right)
    assert "decay.csv" in told
    assert "degrees" in told


def test_two_files_of_which_one_is_in_degrees(tmp_path):
    right = {name: columns for name, columns in runs().items() if name != "w8.csv"}
    made = {name: list(columns) for name, columns in right.items()}
    made["w13.csv"][2] = np.degrees(made["w13.csv"][2])
    (told,) = mended(write(tmp_path, made), right)
    assert told.startswith("w13.csv: phi2 is in degrees")


def test_one_file_in_radians_where_degrees_are_said(tmp_path):
    right = runs()
    made = {n: [t, np.degrees(a), np.degrees(b)] for n, (t, a, b) in right.items()}
    made["w18.csv"] = right["w18.csv"]
    form = (
        '[format.columns]\nt = { column = "t" }\nphi1 = { column = "phi1", unit = "deg" }\n'
        'phi2 = { column = "phi2", unit = "deg" }'
    )
    (told,) = mended(write(tmp_path, made, form=form), right)
    assert told.startswith("w18.csv: phi1 and phi2 are in radians")


def test_one_file_in_counts_of_an_encoder(tmp_path):
    made = runs()
    made["w13.csv"][2] = np.round(made["w13.csv"][2] * 4096.0 / (2.0 * np.pi))
    (wrong,) = check(write(tmp_path, made)).wrong
    assert "w13.csv: phi2 is in counts of an encoder" in wrong.sentence
    assert "counts = N" in wrong.sentence
    text = (tmp_path / "campaign.toml").read_text()
    (tmp_path / "campaign.toml").write_text(
        text.replace('file = "w13.csv"', 'file = "w13.csv"\ncolumns = { phi2 = { counts = 4096 } }')
    )
    assert check(tmp_path).wrong == ()


@pytest.mark.parametrize("unit", ["deg", "gon", "mrad"])
@pytest.mark.parametrize("spoilt", ["phi1", "phi2", "both"])
def test_a_column_of_all_files(unit, spoilt, tmp_path):
    right, made = runs(), runs()
    for columns in made.values():
        for channel in (1, 2) if spoilt == "both" else (int(spoilt[-1]),):
            columns[channel] = columns[channel] * PER_RAD[unit]
    write(tmp_path, made)
    if unit == "gon":  # a gon is 1.11 degrees, and no other file tells them apart
        assert any(name in check(tmp_path).wrong[0].sentence for name in ("degrees", "gons"))
        return
    told = mended(tmp_path, right)
    assert NAMES[unit] in told[0]


@pytest.mark.parametrize("spoilt", ["phi1", "phi2"])
def test_a_small_motion_in_degrees(spoilt, tmp_path):
    """phi1 spans 3, and may well be in radians for all that its span tells."""
    right = {n: [t, 0.07 * a, 0.07 * b] for n, (t, a, b) in runs().items()}
    made = {name: list(columns) for name, columns in right.items()}
    for columns in made.values():
        channel = int(spoilt[-1])
        columns[channel] = np.degrees(columns[channel])
    (told,) = mended(write(tmp_path, made), right)
    assert f"{spoilt} looks in degrees" in told


def test_a_single_run_whose_rider_is_in_degrees(tmp_path):
    t, a, b = made_run()
    made = {"w13.csv": [t, a, np.degrees(b)]}
    (told,) = mended(write(tmp_path, made), {"w13.csv": [t, a, b]})
    assert 'write unit = "deg" for phi2' in told


def test_an_encoder_in_degrees_in_one_file(tmp_path):
    right, made = (runs(quantum=2.0 * np.pi / 4096) for _ in range(2))
    made["w18.csv"][2] = np.degrees(made["w18.csv"][2])
    mended(write(tmp_path, made), right)


@pytest.mark.parametrize("factor", [0.3, 3.0, 8.0, 30.0])
def test_a_sensor_with_another_noise_is_no_other_unit(factor, tmp_path):
    made = runs()
    random = np.random.default_rng(0)
    extra = 1e-3 * np.sqrt(abs(factor**2 - 1.0)) * random.standard_normal(2500)
    for name, columns in made.items():
        if (name == "w18.csv") == (factor > 1.0):
            columns[2] = columns[2] + (extra if factor > 1.0 else 3.0 * extra)
    assert not any(each.kind == "units" for each in check(write(tmp_path, made)).wrong)


@pytest.mark.parametrize("omegas", [(8.0, 13.09, 18.0), (3.0, 6.0, 25.0), (5.0, 12.0, 40.0)])
def test_runs_without_noise_are_in_no_other_unit(omegas, tmp_path):
    """What is left of a motion in high differences is no noise, and goes with a power of omega."""
    t = np.arange(2500) / 250.0
    made = {
        f"w{w}.csv": [t, 0.4 * np.sin(w * t), 0.28 * np.sin(w * t - 0.75 * np.pi)] for w in omegas
    }
    write(tmp_path, made, dict(zip(made, omegas, strict=True)))
    assert check(tmp_path).findings == ()
