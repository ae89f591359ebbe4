"""Dates and clock times: forms that are read, those that nobody can read, and summer time."""

from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from tests.made_runs import OMEGA, made_run, write_toml
from tp_jax.checks import check
from tp_jax.errors import InputError
from tp_jax.recordings import Campaign, CampaignError, Known, Recording, load_campaign, read_columns
from tp_jax.recordings.clock_times import has_zone, is_date_or_clock, seconds_since_first

T, A, B = made_run(n=500)
BEGIN = datetime(2026, 11, 23, 9, 59, 59)


def written(folder, cells: list[str], form: str = ""):
    rows = [f"{t};{a:.9g};{b:.9g}" for t, a, b in zip(cells, A, B, strict=True)]
    (folder / "a.csv").write_text("\n".join(["t;phi1;phi2", *rows]) + "\n")
    write_toml(folder, {"a.csv": OMEGA}, form)
    return folder


def stamps(style: str, begin: datetime = BEGIN) -> list[str]:
    cells = []
    for x in T:
        at = begin + timedelta(microseconds=round(1e6 * x))
        hour = f"{at.hour % 12 or 12}:{at:%M:%S.%f} {'PM' if at.hour >= 12 else 'AM'}"
        cells.append(
            {
                "slashes": f"{at:%Y/%m/%d %H:%M:%S.%f}",
                "one-digit hours": f"{at:%Y-%m-%d} {at.hour}:{at:%M:%S.%f}",
                "German, one-digit hours": f"{at:%d.%m.%Y} {at.hour}:{at:%M:%S,%f}",
                "AM and PM": hour,
                "a date, AM and PM": f"{at.year}/{at.month}/{at.day} {hour}",
                "a.m. and p.m.": hour.replace("M", ".m.").replace(" ", "").lower(),
                "an offset": f"{at:%Y/%m/%d %H:%M:%S.%f} +01:00",
                "Z": f"{at:%Y-%m-%dT%H:%M:%S.%f}Z",
            }[style]
        )
    return cells


STYLES = [
    "slashes",
    "one-digit hours",
    "German, one-digit hours",
    "AM and PM",
    "a date, AM and PM",
    "a.m. and p.m.",
    "an offset",
    "Z",
]


@pytest.mark.parametrize("begin", [BEGIN, datetime(2026, 11, 23, 11, 59, 59)])
@pytest.mark.parametrize("style", STYLES)
def test_forms_that_are_read(style, begin, tmp_path):
    (recording,) = load_campaign(written(tmp_path, stamps(style, begin))).recordings
    np.testing.assert_allclose(recording.t, T, atol=1e-6)
    assert recording.notes == ()


def test_noon_and_midnight():
    cells = ["11:59:59 PM", "12:00:00 AM", "12:30:00 am", "1:00:00 AM", "12:00:00 PM", "1:00 PM"]
    seconds, bad = seconds_since_first(cells)
    assert bad is None
    np.testing.assert_allclose(seconds, [0.0, 1.0, 1801.0, 3601.0, 43201.0, 46801.0])


@pytest.mark.parametrize(
    "cell", ["13:00:00 PM", "0:10:00 AM", "2026/13/01 10:00:00", "2026/11-23 10:00:00", "10:00+02"]
)
def test_no_times(cell):
    assert not is_date_or_clock(cell)


@pytest.mark.parametrize("style", ["{:%m/%d/%Y %H:%M:%S.%f}", "{:%d/%m/%Y %I:%M:%S.%f %p}"])
def test_a_date_whose_day_may_be_either_number_is_refused(style, tmp_path):
    begin = datetime(2026, 11, 12, 10, 15, 0)
    cells = [style.format(begin + timedelta(microseconds=round(1e6 * x))) for x in T]
    with pytest.raises(CampaignError) as caught:
        load_campaign(written(tmp_path, cells))
    told = str(caught.value)
    assert "a.csv, line 2: t is not a number but" in told
    assert "of which the day may be either number" in told
    assert "write dates as 2026-11-23 10:15:30.004, 2026/11/23 10:15:30.004 or" in told
    forms = [f"{begin + timedelta(seconds=x):%Y/%m/%d %H:%M:%S.%f}" for x in T]
    (recording,) = load_campaign(written(tmp_path, forms)).recordings
    np.testing.assert_allclose(recording.t, T, atol=2e-6)


def test_such_a_date_in_a_workbook(tmp_path):
    book = pytest.importorskip("openpyxl").Workbook()
    book.active.append(["t", "phi1", "phi2"])
    for x, y, z in zip(T[:60], A, B, strict=False):
        book.active.append([f"11/12/2026 10:15:{x:06.3f}", float(y), float(z)])
    book.save(tmp_path / "a.xlsx")
    with pytest.raises(CampaignError, match="write dates as 2026-11-23"):
        read_columns(tmp_path / "a.xlsx")


# Offsets from UTC ---------------------------------------------------------------------------------


def with_hour(style: str, hours: float) -> list[str]:
    """Stamps that leap by hours after a second."""
    cells = []
    for x in T:
        at = BEGIN + timedelta(microseconds=round(1e6 * x), hours=hours if x >= 1.0 else 0.0)
        cells.append(style.format(at))
    return cells


@pytest.mark.parametrize("form", ["", "[format.columns]\nt = { summer_time = true }"])
@pytest.mark.parametrize("zone", ["Z", "+01:00", " -05:00"])
def test_a_pause_of_an_hour_in_utc_is_no_summer_time(zone, form, tmp_path):
    cells = with_hour(f"{{:%Y-%m-%dT%H:%M:%S.%f}}{zone}", 1.0)
    assert has_zone(cells[0])
    (recording,) = load_campaign(written(tmp_path, cells, form)).recordings
    np.testing.assert_allclose(recording.t, T + 3600.0 * (T >= 1.0), atol=1e-6)
    assert recording.notes == ()


def test_local_times_have_summer_time_still(tmp_path):
    cells = with_hour("{:%Y/%m/%d %H:%M:%S.%f}", 1.0)
    assert not has_zone(cells[0])
    (wrong,) = check(written(tmp_path, cells)).wrong
    assert "an hour of summer time that begins" in wrong.sentence


def test_a_fall_by_an_hour_in_utc_is_another_run(tmp_path):
    (wrong,) = check(written(tmp_path, with_hour("{:%Y-%m-%dT%H:%M:%S.%f}Z", -1.0))).wrong
    assert "summer" not in wrong.sentence
    assert "split the file before this line" in wrong.sentence


# Arrays -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("unit", ["s", "ms"])
@pytest.mark.parametrize("zone", [None, UTC])
def test_datetimes_of_python_are_dates_in_any_unit(unit, zone):
    begin = BEGIN.replace(tzinfo=zone)
    dates = np.array([begin + timedelta(microseconds=round(1e6 * x)) for x in T], dtype=object)
    for given in (dates, dates.tolist()):
        recording = Recording.from_arrays(given, A, B, omega=OMEGA, t_unit=unit)
        np.testing.assert_allclose(recording.t, T, atol=1e-6)


@pytest.mark.parametrize("zone", [None, UTC])
def test_an_hour_among_datetimes_of_python(zone):
    begin = BEGIN.replace(tzinfo=zone)
    dates = [begin + timedelta(seconds=x, hours=float(x >= 1.0)) for x in T]
    if zone is None:
        with pytest.raises(CampaignError, match="summer time that begins; give times without"):
            Recording.from_arrays(dates, A, B, omega=OMEGA)
    else:
        assert Recording.from_arrays(dates, A, B, omega=OMEGA).duration > 3600.0


@pytest.mark.parametrize("pair", [(0.4, 0.1), [0.4, 0.1], np.array([0.4, 0.1])])
def test_any_pair_is_a_value_and_its_deviation(pair):
    runs = [Recording.from_arrays(T, A, B, omega=OMEGA)]
    campaign = Campaign.from_arrays(runs, B1=1.0, k=pair, B2=np.float64(0.3))
    assert campaign.k == Known(0.4, 0.1)
    assert campaign.B2 == Known(0.3)


NO_TYPE = pytest.param({"value": 1.0}, marks=pytest.mark.unchecked)


@pytest.mark.parametrize("given", [[0.4], [0.4, 0.1, 0.2], [[0.4, 0.1]], "stiff", NO_TYPE])
def test_what_is_no_pair_is_refused(given):
    runs = [Recording.from_arrays(T, A, B, omega=OMEGA)]
    with pytest.raises(InputError, match=r"Argument k must be a number or a pair"):
        Campaign.from_arrays(runs, B1=1.0, k=given)
