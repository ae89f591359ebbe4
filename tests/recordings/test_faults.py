"""Every fault is one line that names the file, its line and the mend."""

import os
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from tp_jax._files import LARGEST
from tp_jax.acquisition import read_calibration
from tp_jax.errors import InputError
from tp_jax.recordings import CampaignError, load_campaign
from tp_jax.recordings.lines import read_lines
from tp_jax.results.diagnosis import DiagnosisRecord

RUN = "run-13.csv"
TOML = "campaign.toml"


def told(path, **given) -> str:
    """The message of the fault; it must be one full line."""
    with pytest.raises(CampaignError) as caught:
        load_campaign(path, **given)
    message = str(caught.value)
    assert "\n" not in message
    assert message[-1] in ".?"
    assert isinstance(caught.value, ValueError)
    assert isinstance(caught.value, InputError)
    assert str(caught.value.file) in message
    assert caught.value.line is None or f"line {caught.value.line}" in message
    return message


# What the campaign.toml says: (text, its replacement, line or None, parts of the message)
TOML_FAULTS = {
    "syntax": ("B1 = 1.2e-3", "B1 = ", 4, ["no TOML", "key = value"]),
    "open string": ('"small"', '"small', 1, ["no TOML"]),
    "unknown key": ("[rig]", 'titel = "x"\n[rig]', 3, ['"titel"', "recording"]),
    "unknown table": ("[rig]", "[rigg]", 3, ['"rigg"', 'did you mean "rig"?']),
    "unknown rig key": ("B1 = 1.2e-3", "b1 = 1.2e-3", 4, ['"b1" in [rig]', 'did you mean "B1"?']),
    "unknown entry key": ("omega = 13.09", "omga = 13.09", 19, ['"omga"', 'mean "omega"?']),
    "unknown format key": ("[rig]", '[format]\ndecimals = ","\n[rig]', 4, ['mean "decimal"?']),
    "unknown column": (
        "[rig]",
        "[format.columns]\nt = {column = 0}\nphi1 = {column = 1}\nfi2 = {column = 2}\n[rig]",
        6,
        ['"fi2"', '"t", "phi1", "phi2"'],
    ),
    "unknown column key": (
        "[rig]",
        "[format.columns]\nt = { colum = 0 }\nphi1 = { column = 1 }\n[rig]",
        4,
        ['"colum"', 'mean "column"?'],
    ),
    "column without source": (
        "[rig]",
        "[format.columns]\nt = { scale = 2.0 }\nphi1 = { column = 1 }\n[rig]",
        4,
        ["t in [format.columns]", "column = 0"],
    ),
    "negative column": (
        "[rig]",
        "[format.columns]\nt = { column = -1 }\nphi1 = { column = 1 }\n[rig]",
        4,
        ["no count"],
    ),
    "column not given": (
        "[rig]",
        "[format.columns]\nt = { column = 0 }\n[rig]",
        3,
        ["phi1", "add phi1"],
    ),
    "zero scale": (
        "[rig]",
        "[format.columns]\nt = { column = 0, scale = 0 }\nphi1 = { column = 1 }\n[rig]",
        4,
        ["scale of t is 0"],
    ),
    "long delimiter": ("[rig]", '[format]\ndelimiter = "::"\n[rig]', 4, ["one character"]),
    "decimal": ("[rig]", '[format]\ndecimal = ";"\n[rig]', 4, ['decimal = ","']),
    "delimiter is decimal": (
        "[rig]",
        '[format]\ndelimiter = "."\ndecimal = "."\n[rig]',
        4,
        ["both"],
    ),
    "skip_lines": ("[rig]", "[format]\nskip_lines = -1\n[rig]", 4, ["skip_lines = 5"]),
    "prior of B2": ("B1 =", "B2 = { value = 5e-4 }\nB1 =", 4, ["lacks its sd", "sd = .."]),
    "k without B1": ("B1 = 1.2e-3", "k = 0.4", 4, ["B1 is not", "B1 = 1 if k is per unit"]),
    "prior key": ("B1 =", "k = { value = 0.4, std = 1.0 }\nB1 =", 4, ['"std"', "sd"]),
    "text for number": ("B1 = 1.2e-3", 'B1 = "1.2e-3"', 4, ["B1 in [rig]", "without quotes"]),
    "flag for number": ("B1 = 1.2e-3", "B1 = true", 4, ["B1", "number"]),
    "infinite": ("B1 = 1.2e-3", "B1 = inf", 4, ["B1", "finite"]),
    "huge": ("B1 = 1.2e-3", f"B1 = 1{'0' * 400}", 4, ["B1", "finite"]),
    "B1 not positive": ("B1 = 1.2e-3", "B1 = -1.2e-3", 4, ["B1", "above zero"]),
    "model": ("B1 =", 'model = "triple"\nB1 =', 4, ["triple", 'model = "single"']),
    "rig is no table": ("[rig]\nB1 = 1.2e-3\nsample_rate = 250.0", "rig = 3", 3, ["[rig]"]),
    "number for text": ('file = "run-13.csv"', "file = 13", 18, ["file", "no text"]),
    "text for flag": ("forced = true", 'forced = "yes"', 15, ["true or false"]),
    "no file key": ('file = "run-13.csv"\n', "", 17, ["names no file", "add file"]),
    "omega missing": ("omega = 13.09\n", "", 17, [RUN, "omega", "rad/s"]),
    "omega and forced missing": (
        "omega = 13.09\nforced = true\n",
        "",
        17,
        [RUN, "forced = false for a free decay"],
    ),
    "omega zero": ("omega = 13.09", "omega = 0.0", 19, [RUN, "above zero", "forced = false"]),
    "omega negative": ("omega = 13.09", "omega = -3", 19, ["above zero"]),
    "drive": ("omega = 13.09", 'drive = "guessed"', 19, [RUN, 'drive = "measured"']),
    "span no pair": ("omega = 13.09", "omega = 1.0\nspan = [0.0]", 20, ["span", "[0.0, 200.0]"]),
    "span reversed": ("omega = 13.09", "omega = 1.0\nspan = [2.0, 1.0]", 20, ["reversed"]),
    "span empty": ("omega = 13.09", "omega = 1.0\nspan = [1.0, 1.0]", 20, ["empty"]),
    "span outside": (
        "omega = 13.09",
        "omega = 1.0\nspan = [9, 12]",
        17,
        [RUN, "no data", "1.996 s"],
    ),
    "span short": ("omega = 13.09", "omega = 1.0\nspan = [0, 0.1]", 17, ["26 samples", "50"]),
    "twice": ('"run-13.csv"', '"./run-06.csv"', 17, ["twice", "spans"]),
    "overlap": (
        "omega = 13.09",
        'omega = 6.0\nheld_out = true\nspan = [0.5, 1.5]\n[[recording]]\nfile = "run-13.csv"\n'
        "omega = 6.0\nspan = [0.0, 1.0]",
        17,
        ["held_out", "overlap"],
    ),
}


@pytest.mark.parametrize("fault", TOML_FAULTS)
def test_fault_in_campaign_toml(fault, campaign_folder, edit):
    old, new, line, parts = TOML_FAULTS[fault]
    edit(TOML, old, new)
    message = told(campaign_folder)
    assert f"{TOML}, line {line}: " in message
    for part in parts:
        assert part in message


def test_no_recordings(campaign_folder):
    path = campaign_folder / TOML
    path.write_text(path.read_text().split("[[recording]]")[0])
    assert re.search(r"campaign\.toml: .* no recordings; add a \[\[recording\]\]", told(path))


def test_single_bracket(campaign_folder):
    (campaign_folder / TOML).write_text('[recording]\nfile = "a.csv"\n')
    assert "[[recording]]" in told(campaign_folder)


def test_all_held_out(campaign_folder):
    path = campaign_folder / TOML
    path.write_text(path.read_text().replace("forced =", "held_out = true\nforced ="))
    message = told(campaign_folder)
    assert f"{TOML}, line 7: every recording is held_out" in message
    assert "remove held_out" in message


def test_toml_is_no_text(campaign_folder):
    (campaign_folder / TOML).write_bytes(b'name = "\xff"\n')
    assert "UTF-8" in told(campaign_folder)


def test_missing_folder(tmp_path):
    message = told(tmp_path / "case-99")
    assert "case-99: there is no such file or folder; name a folder" in message


def test_missing_campaign_toml(tmp_path):
    message = told(tmp_path)
    assert f"{TOML}: there is no such file" in message
    assert "--omega W or --decay" in message


def test_folder_with_options_of_a_single_file(campaign_folder):
    assert "--omega and --decay" in told(campaign_folder, omega=3.0)


@pytest.mark.parametrize(
    "given", [{}, {"omega": 3.0, "decay": True}, {"omega": 0.0}, {"omega": float("nan")}]
)
def test_single_file_needs_its_drive(given, campaign_folder):
    message = told(campaign_folder / RUN, **given)
    assert RUN in message
    assert "--omega W" in message
    assert "--decay" in message


# What a data file holds: (text, its replacement, line, parts of the message)
TEXT_FAULTS = {
    "missing column": ("phi1", "angle", 1, ['no column "phi1"', '"angle"', "[format.columns]"]),
    "misspelt column": ("phi1", "phi_1", 1, ['rename "phi_1" or']),
    "not a number": ("\n0.012,", "\nabc,", 5, ["t is not", '"abc"', "write a number"]),
    "empty cell": ("\n0.012,", "\n,", 5, ["t is not a number", '""']),
    "underscore": ("\n0.012", "\n0_0.012", 5, ["not a number"]),
    "ragged": ("\n0.012,", "\n0.012,1.0,", 5, ["4 cells", "line 1 has 3", "complete"]),
    "blank lines count": ("\n0.012,", "\n\n \nabc,", 7, ["not a number"]),
    "NaN": ("\n0.012,", "\nnan,", 5, ["t is nan", "remove the row"]),
    "time backwards": ("\n0.012", "\n0.001", 5, ["backwards", "0.008 to 0.001 s"]),
    "time repeated": ("\n0.012", "\n0.008", 5, ["repeated", "remove one"]),
}


@pytest.mark.parametrize("fault", TEXT_FAULTS)
def test_fault_in_data(fault, campaign_folder, edit):
    old, new, line, parts = TEXT_FAULTS[fault]
    edit(RUN, old, new)
    message = told(campaign_folder)
    assert f"{RUN}, line {line}: " in message
    for part in parts:
        assert part in message


# Columns of a data file: (what is done to t, phi1, phi2 of 500 samples, place, parts)
def _infinite(t, phi1, phi2):
    phi2[41] = np.inf
    return t, phi1, phi2


DATA_FAULTS = {
    "infinity": (_infinite, ", line 43: ", ["phi2 is inf", "remove"]),
    "degrees": (
        lambda t, a, b: (t, np.degrees(a), np.degrees(b)),
        ": ",
        ["degrees", 'unit = "deg"'],
    ),
    "constant": (lambda t, a, b: (t, 0.0 * a, b), ": ", ["phi1 does not move", "sensor"]),
    "noise alone": (lambda t, a, b: (t, a - 0.5 * np.sin(13.0 * t), b), ": ", ["does not move"]),
    "few samples": (lambda *all_: tuple(each[:49] for each in all_), ": ", ["49 samples", "50"]),
    "milliseconds": (lambda t, a, b: (1e3 * t, a, b), ": ", ["sample_rate", "seconds"]),
}


@pytest.mark.parametrize("fault", DATA_FAULTS)
def test_fault_in_values(fault, campaign_folder, write_run, run_columns):
    spoil, place, parts = DATA_FAULTS[fault]
    write_run(RUN, "t,phi1,phi2", *spoil(*run_columns))
    message = told(campaign_folder)
    assert f"{RUN}{place}" in message
    for part in parts:
        assert part in message


def _winding(t):
    return 20.0 * t + 0.3 * np.sin(9.0 * t)


def test_a_column_that_turns_round_and_round(campaign_folder, edit, write_run, run_columns):
    t, _, phi2 = run_columns
    write_run(RUN, "t,phi1,phi2", t, _winding(t), phi2)
    assert "rotates = true under [rig]" in told(campaign_folder)
    edit(TOML, "[rig]", "[rig]\nrotates = true")
    assert np.ptp(load_campaign(campaign_folder).recordings[2].phi1) > 30.0


@pytest.mark.parametrize(
    ("spoil", "mend"),
    [
        (lambda x: np.degrees(x), 'unit = "deg"'),
        (lambda x: x - 2.0 * np.pi * np.round(x / (2.0 * np.pi)), "wrap = true"),
    ],
)
def test_turns_that_are_not_counted(spoil, mend, campaign_folder, edit, write_run, run_columns):
    t, _, phi2 = run_columns
    write_run(RUN, "t,phi1,phi2", t, spoil(_winding(t)), phi2)
    edit(TOML, "[rig]", "[rig]\nrotates = true")
    message = told(campaign_folder)
    assert "phi1 leaps" in message
    assert mend in message


def test_a_turn_is_told_in_the_files_own_unit(campaign_folder, edit, write_run, run_columns):
    t, _, phi2 = run_columns
    half = np.degrees(_winding(t))
    half -= 180.0 * np.round(half / 180.0)
    write_run(RUN, "t,phi1 [deg],phi2", t, half, phi2)
    edit(TOML, "[rig]", "[rig]\nrotates = true")
    assert "write wrap = 180 for phi1" in told(campaign_folder)


def test_a_leap_across_a_gap_is_none(campaign_folder, edit, write_run, run_columns):
    t, _, phi2 = run_columns
    kept = (t < 0.8) | (t > 1.2)
    write_run(RUN, "t,phi1,phi2", t[kept], _winding(t)[kept], phi2[kept])
    edit(TOML, "[rig]", "[rig]\nrotates = true")
    load_campaign(campaign_folder)


@pytest.mark.parametrize("content", [b"", b"\r\n \r\n\n", b"\xef\xbb\xbf"])
def test_empty_file(content, campaign_folder):
    (campaign_folder / RUN).write_bytes(content)
    assert f"{RUN}: the file is empty" in told(campaign_folder)


def test_header_alone(campaign_folder):
    (campaign_folder / RUN).write_text("t,phi1,phi2\n")
    assert f"{RUN}, line 1: the file has a header but no rows" in told(campaign_folder)


def test_missing_data_file(campaign_folder, edit):
    edit(TOML, RUN, "run_13.csv")
    assert 'run_13.csv: there is no such file; did you mean "run-13.csv"?' in told(campaign_folder)


@pytest.mark.parametrize("name", ["a\\u0000b", "x" * 5000])
def test_file_name_that_cannot_be(name, campaign_folder, edit):
    edit(TOML, RUN, name)
    assert "no such file" in told(campaign_folder)


def test_folder_for_a_data_file(campaign_folder):
    (campaign_folder / RUN).unlink()
    (campaign_folder / RUN).mkdir()
    assert f"{RUN}: the file cannot be read" in told(campaign_folder)


def test_binary_file(campaign_folder):
    (campaign_folder / RUN).write_bytes(bytes(range(256)) * 20)
    assert RUN in told(campaign_folder)


def test_headerless_file_of_five_columns(campaign_folder, write_run, run_columns):
    write_run(RUN, None, *run_columns, *run_columns[:2])
    message = told(campaign_folder)
    assert f"{RUN}, line 1: " in message
    assert "has 5" in message
    assert "t,phi1,phi2" in message


def test_column_index_beyond_the_row(campaign_folder, edit):
    edit(TOML, "[rig]", "[format.columns]\nt = {column = 0}\nphi1 = {column = 7}\n[rig]")
    message = told(campaign_folder)
    assert "decay.csv, line 2: there is no column 7 for phi1" in message
    assert "delimiter" in message


def test_column_name_without_a_header(campaign_folder, edit, write_run, run_columns):
    for file in ("decay.csv", "run-06.csv", RUN, "run-17.csv"):
        write_run(file, None, *run_columns)
    edit(TOML, "[rig]", '[format.columns]\nt = {column = 0}\nphi1 = {column = "a"}\n[rig]')
    assert 'no header to find the column "a"' in told(campaign_folder)


def test_measured_drive_without_its_column(campaign_folder, edit):
    edit(TOML, "omega = 13.09", 'drive = "measured"')
    message = told(campaign_folder)
    assert f"{RUN}, line 1: there is no column drive" in message
    assert "omega" in message


@pytest.mark.parametrize("model", [None, "double"])
def test_phi2_in_some_recordings_only(model, campaign_folder, edit, write_run, run_columns):
    if model:
        edit(TOML, "[rig]", f'[rig]\nmodel = "{model}"')
    write_run(RUN, "t,phi1", *run_columns[:2])
    message = told(campaign_folder)
    assert f"{RUN}, line 1: there is no column phi2" in message
    assert 'model = "single"' in message


def test_phi2_not_mapped(campaign_folder, edit):
    edit(TOML, "[rig]", "[format.columns]\nt = {column = 0}\nphi1 = {column = 1}\n[rig]")
    edit(TOML, "[rig]", '[rig]\nmodel = "double"')
    assert 'phi2 is; add phi2 to it, or write model = "single"' in told(campaign_folder)


def test_held_out_copy_of_a_fitted_file(campaign_folder, edit):
    shutil.copy(campaign_folder / RUN, campaign_folder / "copy.csv")
    edit(TOML, "run-17.csv", "copy.csv")
    edit(TOML, "omega = 17.0", "omega = 17.0\nheld_out = true")
    assert "copy.csv, held_out, are fitted as run-13.csv" in told(campaign_folder)


@pytest.mark.parametrize("device", ["/dev/zero", "/dev/full", "pipe"])
def test_what_has_no_end_is_not_read(device, tmp_path):
    file = Path(device)
    if device == "pipe":
        file = tmp_path / "pipe"
        os.mkfifo(file)
    for read in (
        lambda: read_lines(file),
        lambda: read_calibration(file),
        lambda: DiagnosisRecord.from_json(file),
    ):
        with pytest.raises(InputError, match="device or a pipe") as fault:
            read()
        assert "\n" not in str(fault.value)


def test_a_file_that_is_too_large(tmp_path):
    file = tmp_path / "run.csv"
    with file.open("wb") as stream:
        stream.truncate(LARGEST + 1)  # a hole
    with pytest.raises(InputError, match="more than 2e9 bytes"):
        load_campaign(file, omega=13.0)
