"""Clocks that do not run on: each is named for what it is, and what is advised mends it."""

import warnings
from pathlib import Path

import numpy as np
import pytest

from tests.following import follow
from tests.made_runs import OMEGA, made_run, write_rows, write_toml
from tp_jax.checks import check
from tp_jax.checks.proposal import propose
from tp_jax.errors import Notice
from tp_jax.recordings import CampaignError, Recording, clocks, load_campaign

T, A, B = made_run()
BITS32 = 2.0**32


def written(folder: Path, t, header="t", form="", a=A, b=B, name="a.csv") -> Path:
    write_rows(folder / name, f"{header},phi1,phi2", t, a, b)
    write_toml(folder, {name: OMEGA}, form)
    return folder


def mended(folder: Path, steps: int = 3) -> list[str]:
    """What is wrong, followed until nothing is."""
    told = []
    for _ in range(steps):
        wrong = check(folder).wrong
        if not wrong:
            return told
        told.append(wrong[0].sentence)
        follow(folder, told[-1])
    assert check(folder).wrong == ()
    return told


def is_right(folder: Path, t=T, a=A, within=1e-6) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", Notice)
        (recording,) = load_campaign(folder).recordings
    np.testing.assert_allclose(recording.t - recording.t[0], t - t[0], atol=within)
    np.testing.assert_allclose(recording.phi1, a, atol=1e-8)


def started_by_init(folder: Path) -> None:
    """`init` finds the same, takes the run for a driven one, and all is then well."""
    (folder / "campaign.toml").unlink(missing_ok=True)
    text, _ = propose(folder)
    assert "nan" not in text
    (folder / "campaign.toml").write_text(text, encoding="utf-8")
    assert "forced = true" in text
    assert check(folder).wrong == ()


def signed(cells: np.ndarray, period: float = BITS32) -> np.ndarray:
    return (cells + 0.5 * period) % period - 0.5 * period


# Counters -----------------------------------------------------------------------------------------

MICROS = np.rint(1e6 * T)
MILLIS = np.rint(1e3 * T)
COUNTERS = {
    "micros, 32 bits": ("micros", (MICROS + BITS32 - 3e6) % BITS32, "wrap = 4294967296"),
    "micros, signed": ("micros", signed(MICROS + 0.5 * BITS32 - 4e6), "wrap = 4294967296"),
    "micros, signed, through zero": ("micros", signed(MICROS + BITS32 - 4e6), None),
    "micros, 31 bits": ("micros", (MICROS + 2.0**31 - 5e6) % 2.0**31, "wrap = 2147483648"),
    "millis, 32 bits": ("millis", (MILLIS + BITS32 - 6e3) % BITS32, "wrap = 4294967296"),
    "millis, signed": ("millis", signed(MILLIS + 0.5 * BITS32 - 2e3), "wrap = 4294967296"),
    "millis, 16 bits": ("millis", (MILLIS + 6e4) % 65536.0, "wrap = 65536"),
    "micros in seconds": ("t", (T + 4294.967296 - 3.0) % 4294.967296, "wrap = 4294.967296"),
    "micros in seconds, signed": (
        "t",
        signed(T + 2147.483648 - 3.0, 4294.967296),
        "wrap = 4294.967296",
    ),
    "micros in whole ms": ("millis", (MILLIS + 4294967.0 - 3e3) % 4294967.296 // 1, "4294967.296"),
    "seconds of a day": ("t", (T + 86395.0) % 86400.0, "wrap = 86400"),
}


def cells_of(x: np.ndarray) -> list[str]:
    return [f"{each:.0f}" if np.all(x == np.rint(x)) else f"{each:.6f}" for each in x]


@pytest.mark.parametrize("what", COUNTERS)
@pytest.mark.parametrize("mapped", [False, True], ids=["by names", "mapped"])
def test_a_counter_that_starts_anew(what, mapped, tmp_path):
    name, cells, says = COUNTERS[what]
    unit = {"micros": "us", "millis": "ms", "t": "s"}[name]
    form = ""
    header = "t"
    if mapped:
        header = name
        form = (
            f'[format.columns]\nt = {{ column = "{name}", unit = "{unit}" }}\n'
            'phi1 = { column = "phi1" }\nphi2 = { column = "phi2" }'
        )
    folder = written(tmp_path, cells_of(cells), header, form)
    told = mended(folder)
    assert "order of time" not in " ".join(told)
    within = 1.1e-3 if "whole" in what else 1e-6
    is_right(folder, within=within)
    if says is not None:
        assert says in told[0]
        assert "time runs backwards" in told[0]
        (note,) = [each.sentence for each in check(folder).findings if each.level == "mended"][:1]
        assert "starts anew once" in note
        with pytest.warns(Notice, match="unwrapped"):
            load_campaign(folder)
    started_by_init(written(tmp_path, cells_of(cells), name))


def test_wrap_is_found_where_it_is_only_said_that_there_is_one(tmp_path):
    cells = cells_of(COUNTERS["micros, signed"][1])
    form = '[format.columns]\nt = { unit = "us", wrap = true }'
    folder = written(tmp_path, cells, form=form)
    assert check(folder).wrong == ()
    is_right(folder)


def test_several_turns_of_a_counter_and_samples_lost_over_one(tmp_path):
    t, a, b = made_run(n=20000, rate=100.0)  # three turns of 16 bits of milliseconds
    keep = np.ones(t.size, dtype=bool)
    keep[6550:6555] = False  # over the first
    cells = np.rint(1e3 * t[keep]) % 65536.0
    folder = written(tmp_path, cells_of(cells), a=a[keep], b=b[keep])
    told = mended(folder)
    assert 'unit = "ms", wrap = 65536' in told[0]
    is_right(folder, t[keep], a[keep])


def test_files_of_a_campaign_whose_clock_did_not_start_anew_stay_as_they_are(tmp_path):
    written(tmp_path, cells_of(COUNTERS["micros, 32 bits"][1]))
    write_rows(tmp_path / "b.csv", "t,phi1,phi2", cells_of(MICROS + 7e6), A, B)
    write_toml(tmp_path, {"a.csv": OMEGA, "b.csv": OMEGA})
    mended(tmp_path)
    with pytest.warns(Notice):
        both = load_campaign(tmp_path).recordings
    for recording in both:
        np.testing.assert_allclose(np.diff(recording.t), 0.004, atol=1e-6)


# Resets, joined logs, rows out of order -----------------------------------------------------------


def reset(t: np.ndarray, at: int, to: float = 0.0) -> np.ndarray:
    return np.concatenate([t[:at], t[at:] - t[at] + to])


RESETS = {
    "a board that was reset": reset(T, 1200),
    "after a boot message's time": reset(T, 900, 0.731),
    "two logs of a clock that runs on elsewhere": reset(T + 700.0, 1100, 120.0),
    "micros, near the period by chance": 1e-6 * reset(MICROS + 4.0e9, 1000, 0.0),
    "two logs of an hour each": reset(T + 3590.0, 2500 - 10, 3590.0) - 3590.0,
    "half a step between": reset(T, 1250, 0.002),
}


@pytest.mark.parametrize("what", RESETS)
def test_a_reset_is_no_counter_and_no_disorder(what, tmp_path):
    t = RESETS[what]
    at = int(np.flatnonzero(np.diff(t) < 0.0)[0]) + 1
    (wrong,) = check(written(tmp_path, [f"{x:.6f}" for x in t])).wrong
    assert f"line {at + 2}: " in wrong.sentence
    assert "after a reset of the board or where two logs were joined" in wrong.sentence
    if min(at, t.size - at) > 50:
        follow(tmp_path, wrong.sentence)
        assert check(tmp_path).wrong == ()
        first, second = load_campaign(tmp_path).recordings
        assert (first.n, second.n) == (at, t.size - at)
        np.testing.assert_allclose(second.phi1, A[at:], atol=1e-8)


@pytest.mark.parametrize("what", ["two rows", "blocks", "newest first"])
def test_rows_out_of_order_are_told_as_that(what, tmp_path):
    order = np.arange(T.size)
    if what == "two rows":
        order[[700, 701, 1500, 1501, 1502]] = [701, 700, 1502, 1501, 1500]
    elif what == "blocks":
        order = np.concatenate([order[:500], order[1000:1500], order[500:1000], order[1500:]])
    else:
        order = order[::-1]
    folder = written(tmp_path, [f"{x:.6f}" for x in T[order]], a=A[order], b=B[order])
    (told,) = mended(folder)
    assert "put the rows in order of time" in told
    is_right(folder)


@pytest.mark.parametrize(("row", "value"), [(800, 0.5), (800, 99.0), (801, -3.0)])
def test_a_single_time_that_is_wrong_is_one_row_to_be_removed(row, value, tmp_path):
    t = T.copy()
    t[row] = value
    (wrong,) = check(written(tmp_path, [f"{x:.6f}" for x in t])).wrong
    assert f"line {row + 2}: " in wrong.sentence
    assert "remove the row" in wrong.sentence


# Summer time --------------------------------------------------------------------------------------


def local(t: np.ndarray, begin: str, shift: float, after: float, style: str) -> list[str]:
    """Local times that are shifted by so many seconds after so many."""
    start = np.datetime64(begin, "us")
    cells = []
    for x in t:
        moved = x + (shift if x >= after else 0.0)
        iso = str(start + np.timedelta64(round(1e6 * moved), "us"))
        day, clock = iso.split("T")
        year, month, number = day.split("-")
        german = f"{number}.{month}.{year} {clock[:-3].replace('.', ',')}"
        cells.append({"iso": iso, "german": german, "clock": clock[:-3]}[style])
    return cells


ENDS = ("2025-10-26T02:59:55", -3600.0, 5.0)
BEGINS = ("2026-03-29T01:59:53", 3600.0, 7.0)


@pytest.mark.parametrize("style", ["iso", "german", "clock"])
@pytest.mark.parametrize(("hour", "says"), [(ENDS, "ends"), (BEGINS, "begins")])
def test_an_hour_of_summer_time(hour, says, style, tmp_path):
    cells = local(T, *hour, style)
    write_rows(tmp_path / "a.csv", "Zeit;phi1;phi2", cells, A, B, delimiter=";")
    form = '[format.columns]\nt = { column = "Zeit" }\nphi1 = { column = "phi1" }\n'
    write_toml(tmp_path, {"a.csv": OMEGA}, form + 'phi2 = { column = "phi2" }')
    (told,) = mended(tmp_path)
    assert f"an hour of summer time that {says}" in told
    assert "summer_time = true" in told
    is_right(tmp_path)
    assert "summer time" in check(tmp_path).findings[0].sentence
    (tmp_path / "campaign.toml").unlink()
    text, notes = propose(tmp_path)
    assert (
        "summer_time = true }  # dates or clock times, in seconds from the first, an hour of "
        in text
    )
    assert "summer time" in notes[0]
    started_by_init(tmp_path)


def test_rows_lost_while_the_clock_is_set_back(tmp_path):
    keep = (T < 4.5) | (T > 5.5)
    write_rows(tmp_path / "a.csv", "t,phi1,phi2", local(T[keep], *ENDS, "iso"), A[keep], B[keep])
    write_toml(tmp_path, {"a.csv": OMEGA})
    mended(tmp_path)
    is_right(tmp_path, T[keep], A[keep])


def test_a_pause_of_an_hour_and_some_is_no_summer_time(tmp_path):
    cells = local(T, BEGINS[0], 3712.0, 5.0, "iso")
    write_rows(tmp_path / "a.csv", "t,phi1,phi2", cells, A, B)
    assert load_campaign(tmp_path / "a.csv", omega=OMEGA).recordings[0].duration > 3700.0


def test_offsets_of_time_zones_are_no_summer_time(tmp_path):
    cells = [
        f"{each}{'+02:00' if x < 5.0 else '+01:00'}"
        for each, x in zip(local(T, *ENDS, "iso"), T, strict=True)
    ]
    folder = written(tmp_path, cells)
    assert check(folder).findings == ()
    is_right(folder)


def test_dates_of_an_array_are_told_too():
    start = np.datetime64("2025-10-26T02:59:55", "us")
    moved = T + np.where(T >= 5.0, -3600.0, 0.0)
    dates = start + np.rint(1e6 * moved).astype("timedelta64[us]")
    with pytest.raises(CampaignError, match="an hour of summer time that ends; give times without"):
        Recording.from_arrays(dates, A, B, omega=OMEGA)


# Units --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("step", "unit"), [(0.004, None), (4.0, "ms"), (4000.0, "us")])
def test_the_unit_of_a_step(step, unit):
    assert clocks.unit_of_step(step) == unit


@pytest.mark.parametrize(
    ("key", "value", "says"),
    [
        ("t", "summer_time = 3", "write summer_time = true or false"),
        ("phi1", "summer_time = true", "phi1 is no time"),
        ("t", "wrap = -3", "above zero"),
    ],
)
def test_settings_that_cannot_be(key, value, says, tmp_path):
    folder = written(tmp_path, T, form=f"[format.columns]\n{key} = {{ {value} }}")
    assert says in check(folder).wrong[0].sentence


def decay(rate: float) -> tuple[np.ndarray, ...]:
    t = np.arange(round(10.0 * rate)) / rate
    noise = 1e-3 * np.random.default_rng(0).standard_normal((2, t.size))
    swing = 0.5 * np.exp(-0.3 * t) * np.cos(14.0 * t)
    return t, swing + noise[0], 0.3 * swing + noise[1]


@pytest.mark.parametrize(("factor", "unit"), [(1e3, "ms"), (1e6, "us")])
@pytest.mark.parametrize("rate", [100.0, 250.0, 1000.0, 5000.0])
def test_milliseconds_and_microseconds_of_a_decay_are_named(factor, unit, rate, tmp_path):
    t, a, b = decay(rate)
    write_rows(tmp_path / "a.csv", "t,phi1,phi2", factor * t, a, b)
    (tmp_path / "campaign.toml").write_text('[[recording]]\nfile = "a.csv"\nforced = false\n')
    (doubt,) = check(tmp_path).doubtful
    named = {"ms": "milliseconds", "us": "microseconds"}[unit]
    assert f"probably in {named}" in doubt.sentence
    follow(tmp_path, doubt.sentence)
    assert check(tmp_path).findings == ()
    is_right(tmp_path, t, a)


@pytest.mark.parametrize(("factor", "unit"), [(1e3, "ms"), (1e6, "us")])
def test_milliseconds_and_microseconds_of_a_driven_run_are_refused(factor, unit, tmp_path):
    folder = written(tmp_path, factor * T)
    checked = check(folder)
    (wrong,) = checked.wrong
    assert f'write unit = "{unit}"' in wrong.sentence
    assert not any("unit" in each.mend and unit not in each.mend for each in checked.doubtful)
    follow(folder, wrong.sentence)
    assert check(folder).findings == ()
    is_right(folder)


def said_of_t(folder: Path, said: str) -> Path:
    toml = folder / "campaign.toml"
    text = toml.read_text(encoding="utf-8")
    columns = f"[format.columns]\nt = {{ {said} }}\n\n[[recording]]"
    toml.write_text(text.replace("[[recording]]", columns, 1), encoding="utf-8")
    return toml


@pytest.mark.parametrize(
    ("said", "factor", "unit"),
    [('unit = "ms"', 1e6, "us"), ('unit = "us"', 1e9, "ns"), ('unit = "ms"', 1.0, "s")],
)
def test_another_unit_than_the_one_that_was_said(said, factor, unit, tmp_path):
    folder = written(tmp_path, factor * T)
    toml = said_of_t(folder, said)
    (wrong,) = check(folder).wrong
    assert f'write unit = "{unit}"' in wrong.sentence
    for each in check(folder).doubtful:
        assert "unit" not in each.mend or f'"{unit}"' in each.mend
    toml.write_text(
        toml.read_text(encoding="utf-8").replace(said, f'unit = "{unit}"'), encoding="utf-8"
    )
    assert check(folder).findings == ()
    is_right(folder)


def test_a_scale_that_was_said_goes_where_a_unit_comes(tmp_path):
    folder = written(tmp_path, 1e6 * T)
    said_of_t(folder, "scale = 1e-3")
    (wrong,) = check(folder).wrong
    assert 'write unit = "us"' in wrong.sentence
    assert "without its scale" in wrong.sentence


def test_a_slow_pendulum_with_one_sample_a_second_is_read(tmp_path):
    t = np.arange(600.0)
    write_rows(tmp_path / "a.csv", "t,phi1", t, 0.3 * np.exp(-t / 400) * np.cos(t / 3.0))
    (tmp_path / "campaign.toml").write_text('[[recording]]\nfile = "a.csv"\nforced = false\n')
    assert check(tmp_path).wrong == ()


# A board's time since it was switched on ----------------------------------------------------------


def campaign_of(folder: Path, begins: dict[str, float], runs=None) -> Path:
    omegas = dict(zip(begins, (10.0, OMEGA, 17.0), strict=False))
    for name, begin in begins.items():
        t, a, b = (runs or made_run)(omega=omegas[name])
        write_rows(folder / name, "t,phi1,phi2", [f"{x:.6f}" for x in t + begin], a, b)
    write_toml(folder, omegas)
    return folder


def test_runs_that_begin_from_rest_at_times_of_their_own(tmp_path):
    campaign_of(tmp_path, {"a.csv": 0.0, "b.csv": 137.123, "c.csv": 2143.4})
    checked = check(tmp_path)
    (doubt,) = checked.doubtful
    assert doubt.sentence.startswith("b.csv, c.csv: times begin at 137.1 s")
    follow(tmp_path, doubt.sentence)
    assert check(tmp_path).findings == ()
    assert [each.t[0] for each in load_campaign(tmp_path).recordings] == [0.0, 0.0, 0.0]


def test_counters_of_several_files_begin_at_their_runs(tmp_path):
    for i, name in enumerate(("a.csv", "b.csv")):
        cells = (MICROS + 1.7e9 * (i + 1) + 8.9e8) % BITS32  # the second starts anew
        write_rows(tmp_path / name, "t,phi1,phi2", cells_of(cells), A, B)
    write_toml(tmp_path, {"a.csv": OMEGA, "b.csv": OMEGA})
    mended(tmp_path)
    assert check(tmp_path).doubtful == ()
    with pytest.warns(Notice, match="from the first row"):
        both = load_campaign(tmp_path).recordings
    for recording in both:
        np.testing.assert_allclose(recording.t, T, atol=1e-6)


def swinging(**given) -> tuple[np.ndarray, ...]:
    t, a, b = made_run(n=3500, **given)
    return t[1000:] - t[1000], a[1000:], b[1000:]


@pytest.mark.parametrize(
    ("begins", "runs"),
    [
        ({"a.csv": 0.0, "b.csv": 0.0}, None),
        ({"a.csv": 137.123}, None),  # its phase is found
        ({"a.csv": 0.0, "b.csv": 4.8}, swinging),  # cut from a run that goes on
        ({"a.csv": 0.004, "b.csv": 0.0}, None),
    ],
)
def test_other_beginnings_are_no_matter(begins, runs, tmp_path):
    assert check(campaign_of(tmp_path, begins, runs)).doubtful == ()
