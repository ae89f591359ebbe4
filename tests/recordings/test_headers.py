"""Names and units above the rows: each is read as it is meant, or refused with what to write."""

from pathlib import Path

import numpy as np
import pytest

from tp_jax.recordings import CampaignError, load_campaign, read_columns
from tp_jax.recordings.units import ANGLE, FREQUENCY, TIME, named

T = np.arange(100) / 250.0
PHI1, PHI2 = 0.5 * np.sin(13.0 * T), 0.3 * np.sin(13.0 * T - 0.4)
SPEEDS = np.gradient(PHI1, T), np.gradient(PHI2, T)


def rows(*columns: np.ndarray, between: str = " ") -> str:
    return "\n".join(
        between.join(f"{cell:.12g}" for cell in row) for row in zip(*columns, strict=True)
    )


def is_read(file: Path, *columns: np.ndarray) -> None:
    values = read_columns(file).values
    assert list(values) == ["t", "phi1", "phi2"][: len(columns)]
    for value, truth in zip(values.values(), columns, strict=True):
        np.testing.assert_allclose(value, truth, atol=1e-9)


# Units that are words of their own ----------------------------------------------------------------

WORDS = [
    "t [s] phi1 [rad] phi2 [rad] omega1 [rad/s] omega2 [rad/s]",
    "t (s) phi1 (rad) phi2 (rad) omega1 (rad / s) omega2 (rad / s)",
    "t /s phi1 /rad phi2 /rad omega1 /rad/s omega2 /rad/s",
    "t / s phi1 / rad phi2 / rad omega1 / rad/s omega2 / rad/s",
    "t[s] phi1 [rad]  phi2\t[rad] omega1 omega2",
    "t phi1 phi2 omega1 omega2\n[s] [rad] [rad] [rad/s] [rad/s]",
]


@pytest.mark.parametrize("hash_mark", ["", "# "])
@pytest.mark.parametrize("header", WORDS)
def test_units_that_are_words_of_their_own(header, hash_mark, tmp_path):
    text = "\n".join(hash_mark + line for line in header.split("\n"))
    (tmp_path / "a.txt").write_text(f"{text}\n{rows(T, PHI1, PHI2, *SPEEDS)}\n")
    is_read(tmp_path / "a.txt", T, PHI1, PHI2)


def test_a_header_of_savetxt_in_other_units_and_order(tmp_path):
    columns = np.column_stack([*SPEEDS, np.degrees(PHI1), np.degrees(PHI2), 1e3 * T])
    header = "omega1 [rad/s] omega2 [rad/s] phi1 [deg] phi2 [deg] t [ms]"
    np.savetxt(tmp_path / "a.txt", columns, header=header)
    is_read(tmp_path / "a.txt", T, PHI1, PHI2)


@pytest.mark.parametrize(
    ("header", "columns"),
    [
        ("speed 1 t phi1 phi2", (SPEEDS[0], T, PHI1, PHI2)),
        ("t phi1 phi2", (np.arange(T.size), T, PHI1, PHI2)),  # the rows' numbers have no name
        ("% t phi1 phi2", (T, PHI1, PHI2)),
    ],
)
def test_a_header_that_does_not_fit_the_rows_is_refused(header, columns, tmp_path):
    (tmp_path / "a.csv").write_text(f"{header}\n{rows(*columns)}\n")
    with pytest.raises(CampaignError, match=r"line 1: .* cells between white space.* column = 0"):
        read_columns(tmp_path / "a.csv")
    first = len(columns) - 3
    (tmp_path / "campaign.toml").write_text(
        f"[format.columns]\nt = {{ column = {first} }}\nphi1 = {{ column = {first + 1} }}\n"
        f"phi2 = {{ column = {first + 2} }}\n[[recording]]\nfile = 'a.csv'\nforced = false\n"
    )
    (recording,) = load_campaign(tmp_path).recordings
    np.testing.assert_allclose(recording.t, T, atol=1e-9)
    np.testing.assert_allclose(recording.phi2, PHI2, atol=1e-9)


def test_a_name_that_the_header_lacks_is_told_first(tmp_path):
    (tmp_path / "a.csv").write_text(f"measured on Monday by me\n{rows(T, PHI1, PHI2)}\n")
    with pytest.raises(CampaignError, match='there is no column "t" among "measured", "on"'):
        read_columns(tmp_path / "a.csv")


# Names with brackets in a table -------------------------------------------------------------------


def workbook(file: Path, *columns: tuple[str, np.ndarray]) -> None:
    book = pytest.importorskip("openpyxl").Workbook()
    book.active.append([name for name, _ in columns])
    for row in zip(*(cells for _, cells in columns), strict=True):
        book.active.append([float(cell) for cell in row])
    book.save(file)


def test_units_of_a_workbook_are_no_indices_of_a_matrix(tmp_path):
    named_so = [
        ("Winkel2 [°]", np.degrees(PHI2)),
        ("Zeit [ms]", 1e3 * T),
        ("Winkel1 [°]", np.degrees(PHI1)),
    ]
    for columns in (named_so, named_so[1:]):
        workbook(tmp_path / "a.xlsx", *columns)
        with pytest.raises(CampaignError, match=r'no column "t" among .*"Zeit \[ms\]"'):
            read_columns(tmp_path / "a.xlsx")


@pytest.mark.parametrize("n", [2, 3])
def test_a_nameless_matrix_has_its_columns_in_order(n, tmp_path):
    columns = (T, PHI1, PHI2)[:n]
    np.save(tmp_path / "a.npy", np.column_stack(columns))
    is_read(tmp_path / "a.npy", *columns)


# Units spelled otherwise --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "table", "unit"),
    [
        ("S", TIME, "s"),
        ("Sec.", TIME, "s"),
        ("Seconds", TIME, "s"),
        ("second(s)", TIME, "s"),
        ("MS", TIME, "ms"),
        ("Ms", TIME, "ms"),
        ("Msec", TIME, "ms"),
        ("Deg", ANGLE, "deg"),
        ("deg.", ANGLE, "deg"),
        ("DEGREES", ANGLE, "deg"),
        ("Rad", ANGLE, "rad"),
        ("Radian", ANGLE, "rad"),
        ("Milliradians", ANGLE, "mrad"),
        ("RPM", FREQUENCY, "rpm"),
        ("mhz", FREQUENCY, "mHz"),
        ("MHz", FREQUENCY, None),
        ("Mrad", ANGLE, None),
        ("Deg", TIME, None),
        ("", ANGLE, None),
        (".", ANGLE, None),
    ],
)
def test_units_by_their_names(text, table, unit):
    assert named(text, table) == unit


@pytest.mark.parametrize(
    "header",
    [
        "t [MS];phi1 [Deg];phi2 [Degrees]",
        "t (Ms);phi1 (deg.);phi2 (DEG)",
        "t/ms.;phi1/Deg.;phi2/Degree",
        "t;phi1;phi2\nmsec;Deg;Deg",
        "t;phi1;phi2\n[Ms];[deg.];[Degrees]",
        "t [ms];phi1;phi2\n;DEG;DEG",
    ],
)
def test_units_that_are_spelled_otherwise(header, tmp_path):
    cells = rows(1e3 * T, np.degrees(PHI1), np.degrees(PHI2), between=";")
    (tmp_path / "a.csv").write_text(f"{header}\n{cells}\n")
    is_read(tmp_path / "a.csv", T, PHI1, PHI2)


@pytest.mark.parametrize(
    "header",
    [
        "t [S];phi1 [Rad];phi2 [RADIANS]",
        "t;phi1;phi2\nS;Rad;-",
        "t;phi1;phi2\n-----;-----;-----",
        "t;phi1 [-];phi2",
        "t;phi1;phi2;phi2 (raw)",  # the name alone comes first
        "t;phi1;phi2 [rad];phi2 (raw)",
    ],
)
def test_what_changes_no_number(header, tmp_path):
    cells = rows(T, PHI1, PHI2, *([PHI1] if "raw" in header else []), between=";")
    (tmp_path / "a.csv").write_text(f"{header}\n{cells}\n")
    is_read(tmp_path / "a.csv", T, PHI1, PHI2)


@pytest.mark.parametrize(
    ("header", "name", "cell", "line"),
    [
        ("t [ticks];phi1;phi2", "t", "t [ticks]", 1),
        ("t [ms];phi1 [Gr.];phi2 [deg]", "phi1", "phi1 [Gr.]", 1),
        ("t [ms];phi1 [deg];phi2 (raw)", "phi2", "phi2 (raw)", 1),
        ("t [ms];phi1 [deg];phi2/Altgrad", "phi2", "phi2/Altgrad", 1),
        ("t;phi1;phi2\nms;deg;Altgrad", "phi2", "Altgrad", 1),
    ],
)
def test_a_unit_that_is_not_known_is_refused(header, name, cell, line, tmp_path):
    cells = rows(1e3 * T, np.degrees(PHI1), np.degrees(PHI2), between=";")
    (tmp_path / "a.csv").write_text(f"{header}\n{cells}\n")
    with pytest.raises(CampaignError) as caught:
        read_columns(tmp_path / "a.csv")
    told = str(caught.value)
    assert f'line {line}: the unit of {name} is not known in the cell "{cell}"' in told
    assert f'"{"ms" if name == "t" else "deg"}"' in told
    assert f"under [format.columns] in campaign.toml, as in {name} = {{ unit = " in told
    # as it says
    unit = {"t": "ms"}.get(name, "deg")
    given = [f'{name} = {{ unit = "{unit}" }}']
    if name == "t":  # the header says nothing of the others
        given += ['phi1 = { unit = "deg" }', 'phi2 = { unit = "deg" }']
    (tmp_path / "campaign.toml").write_text(
        "[format.columns]\n" + "\n".join(given) + "\n[[recording]]\nfile = 'a.csv'\nforced = false"
    )
    (recording,) = load_campaign(tmp_path).recordings
    read = (recording.t, *recording.channels.values())
    for value, truth in zip(read, (T, PHI1, PHI2), strict=True):
        np.testing.assert_allclose(value, truth, atol=1e-9)


def test_a_unit_of_a_column_that_is_not_read_does_not_matter(tmp_path):
    cells = rows(T, PHI1, PHI2, between=";")
    (tmp_path / "a.csv").write_text(f"t;phi1;phi2 (broken)\n{cells}\n")
    assert list(read_columns(tmp_path / "a.csv", wanted=("t", "phi1")).values) == ["t", "phi1"]


def test_a_drive_may_be_in_any_unit(tmp_path):
    cells = rows(T, PHI1, 3.0 * PHI2, between=";")
    (tmp_path / "a.csv").write_text(f"t;phi1;drive [V]\n{cells}\n")
    np.testing.assert_allclose(read_columns(tmp_path / "a.csv").values["drive"], 3.0 * PHI2)


def test_units_of_a_workbook(tmp_path):
    columns = [("t [MS]", 1e3 * T), ("phi1 [Deg]", np.degrees(PHI1)), ("phi2 [?]", PHI2)]
    workbook(tmp_path / "a.xlsx", *columns)
    with pytest.raises(CampaignError, match=r'an Excel workbook, and the unit of phi2 .*"phi2 \['):
        read_columns(tmp_path / "a.xlsx")
    workbook(tmp_path / "a.xlsx", *columns[:2], ("phi2 [Rad.]", PHI2))
    is_read(tmp_path / "a.xlsx", T, PHI1, PHI2)
