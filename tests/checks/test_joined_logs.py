"""Rows without numbers between rows of numbers: names again, and separators only."""

import io
import warnings

import numpy as np
import pytest

from tests.following import follow
from tests.made_runs import OMEGA, made_run, write_rows, write_toml
from tp_jax.checks import check
from tp_jax.checks.proposal import propose
from tp_jax.cli import main
from tp_jax.errors import Notice
from tp_jax.recordings import load_campaign

T, A, B = made_run()


@pytest.fixture
def lines(tmp_path) -> list[str]:
    write_rows(tmp_path / "a.csv", "t,phi1,phi2", T, A, B)
    write_toml(tmp_path, {"a.csv": OMEGA})
    return (tmp_path / "a.csv").read_text().splitlines()


def spoilt(folder, lines) -> str:
    (folder / "a.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    (wrong,) = check(folder).wrong
    return wrong.sentence


def is_right(folder) -> None:
    (recording,) = load_campaign(folder).recordings
    np.testing.assert_allclose(recording.t, T, atol=1e-8)
    np.testing.assert_allclose(recording.phi2, B, atol=1e-8)
    assert check(folder).findings == ()


# Names again --------------------------------------------------------------------------------------


@pytest.mark.parametrize("at", [3, 150, 1201, 1250, 2400])
def test_names_again_are_one_line_to_be_removed(at, lines, tmp_path):
    told = spoilt(tmp_path, [*lines[:at], lines[0], *lines[at:]])
    assert f"line {at + 1}: the columns' names stand here again" in told
    follow(tmp_path, told)
    is_right(tmp_path)


def test_names_every_now_and_then(lines, tmp_path):
    told = spoilt(
        tmp_path, [*lines[:500], lines[0], *lines[500:900], "t, phi1 ,PHI2", *lines[900:]]
    )
    assert "in 2 rows, lines 501, 902" in told
    follow(tmp_path, told)
    is_right(tmp_path)


def test_names_and_units_again(lines, tmp_path):
    head = ["t,phi1,phi2", "s,rad,rad"]
    told = spoilt(tmp_path, [*head, *lines[1:800], *head, *lines[800:]])
    assert "in 2 rows, lines 802, 803" in told
    follow(tmp_path, told)
    is_right(tmp_path)


def test_a_second_file_with_its_byte_order_mark(lines, tmp_path):
    told = spoilt(tmp_path, [*lines[:800], "\ufeff" + lines[0], *lines[800:]])
    assert "the columns' names stand here again" in told
    follow(tmp_path, told)
    is_right(tmp_path)


def test_names_that_stand_in_the_middle_only(lines, tmp_path):
    told = spoilt(tmp_path, [*lines[1:801], lines[0], *lines[801:]])
    assert "line 801: the columns' names stand here again" in told
    follow(tmp_path, told)
    is_right(tmp_path)


def test_all_that_a_program_writes_above_its_rows(lines, tmp_path):
    head = ["bench 3,,", "rate,250,", "remark,the second today,", lines[0]]
    told = spoilt(tmp_path, [*head, *lines[1:800], *head, *lines[800:]])
    assert "line 804: the columns' names stand here again, in 4 rows" in told
    follow(tmp_path, told)
    is_right(tmp_path)


def test_names_between_white_space(lines, tmp_path):
    rows = [line.replace(",", " ") for line in lines]
    told = spoilt(tmp_path, [*rows[:600], rows[0], *rows[600:]])
    follow(tmp_path, told)
    is_right(tmp_path)


def test_a_remark_of_some_words_is_no_row_of_names(lines, tmp_path):
    rows = [line.replace(",", " ") for line in lines]
    told = spoilt(tmp_path, [*rows[:600], "the belt was tightened here", *rows[600:]])
    assert "line 601: words stand here and no numbers" in told
    follow(tmp_path, told)
    is_right(tmp_path)


def test_what_a_board_writes_that_was_reset(lines, tmp_path):
    boot = ["rst cause:2, boot mode:(3,6)", "ready"]
    told = spoilt(tmp_path, [*lines[:1001], *boot, *lines[1:1500]])
    assert "line 1002: words stand here and no numbers, in 2 rows, lines 1002, 1003" in told
    assert "as after a reset of the board; remove these lines, and split the file there" in told


def test_names_at_the_very_end(lines, tmp_path):
    told = spoilt(tmp_path, [*lines, lines[0]])
    follow(tmp_path, told)
    is_right(tmp_path)


def test_logs_of_two_runs(lines, tmp_path):
    told = spoilt(tmp_path, [*lines[:1400], *lines])
    assert "line 1401: the columns' names stand here again" in told
    assert "the times begin anew" in told
    follow(tmp_path, told)
    first, second = load_campaign(tmp_path).recordings
    assert (first.n, second.n) == (1399, 2500)


OTHERS = {
    "another order": "t,phi2,phi1",
    "another unit": "t [s],phi1 [deg],phi2 [deg]",
    "more columns": "t,phi1,phi2,motor",
}


@pytest.mark.parametrize("what", OTHERS)
def test_other_names_are_told_and_not_to_be_removed(what, lines, tmp_path):
    t, a, b = T[1000:], A[1000:], B[1000:]
    columns = {
        "another order": (t, b, a),
        "another unit": (t, np.degrees(a), np.degrees(b)),
        "more columns": (t, a, b, 0.0 * t),
    }[what]
    part = io.StringIO()
    np.savetxt(part, np.column_stack(columns), fmt="%.9g", delimiter=",")
    told = spoilt(tmp_path, [*lines[:1001], OTHERS[what], *part.getvalue().splitlines()])
    assert "line 1002: other names of columns stand here" in told
    assert "split the file before this line" in told
    follow(tmp_path, told)
    first, second = load_campaign(tmp_path).recordings
    np.testing.assert_allclose(first.phi1, A[:1000], atol=1e-8)
    np.testing.assert_allclose(second.phi1, A[1000:], atol=1e-8)
    np.testing.assert_allclose(second.phi2, B[1000:], atol=1e-8)


def test_a_german_log_with_names_and_units_again(tmp_path):
    head = ["Zeit;Winkel1;Winkel2", "[ms];[°];[°]"]
    rows = [
        f"{1e3 * x:.3f};{np.degrees(y):.6f};{np.degrees(z):.6f}".replace(".", ",")
        for x, y, z in zip(T, A, B, strict=True)
    ]
    text = "\n".join([*head, *rows[:1300], *head, *rows[1300:]]) + "\n"
    (tmp_path / "a.csv").write_text(text, encoding="utf-8")
    assert main(["init", str(tmp_path)]) == 2
    form = '[format.columns]\nt = { column = "Zeit", unit = "ms" }\n'
    form += 'phi1 = { column = "Winkel1", unit = "deg" }\n'
    form += 'phi2 = { column = "Winkel2", unit = "deg" }'
    write_toml(tmp_path, {"a.csv": OMEGA}, form)
    (wrong,) = check(tmp_path).wrong
    assert "line 1303: the columns' names stand here again, in 2 rows" in wrong.sentence
    follow(tmp_path, wrong.sentence)
    assert check(tmp_path).findings == ()
    assert load_campaign(tmp_path).recordings[0].n == T.size


def test_init_names_the_line(lines, tmp_path, capsys):
    spoilt(tmp_path, [*lines[:900], lines[0], *lines[900:]])
    (tmp_path / "campaign.toml").unlink()
    assert main(["init", str(tmp_path)]) == 2
    told = capsys.readouterr().err
    assert "line 901: the columns' names stand here again" in told
    assert "remove the line." in told


def test_a_row_of_one_word(lines, tmp_path):
    told = spoilt(tmp_path, [*lines[:900], "restart", *lines[900:]])
    assert 'line 901: words stand here and no numbers, "restart"; remove the line.' in told


# Separators only ----------------------------------------------------------------------------------

EMPTY = {
    ";": (";;", "utf-16"),
    ",": (",,", "utf-8"),
    "\t": ("\t\t", "utf-8-sig"),
    "; quoted": ('"";"";""', "cp1252"),
}


@pytest.mark.parametrize("what", EMPTY)
@pytest.mark.parametrize("places", [(7,), (2, 700, -1, -1), (1250, 1251, 1252, 1253)], ids=str)
def test_rows_of_separators_are_left_out_and_said_once(what, places, tmp_path):
    empty, encoding = EMPTY[what]
    delimiter = what[0]
    decimal = "," if delimiter == ";" else "."
    rows = ["sep=;"] if delimiter == ";" else []
    rows.append(delimiter.join(["Zeit [ms]", "Winkel1 [°]", "Winkel2 [°]"]))
    for x, y, z in zip(T, np.degrees(A), np.degrees(B), strict=True):
        cells = [f"{1e3 * x:.1f}", f"{y:.6f}", f"{z:.6f}"]
        rows.append(delimiter.join(cell.replace(".", decimal) for cell in cells))
    for place in places:
        rows.insert(place if place > 0 else len(rows), empty)
    (tmp_path / "lauf.csv").write_bytes("\r\n".join([*rows, ""]).encode(encoding))
    text, notes = propose(tmp_path)
    (tmp_path / "campaign.toml").write_text(text, encoding="utf-8")
    assert "forced = true" in text
    checked = check(tmp_path)
    assert checked.wrong == checked.doubtful == ()
    told = [each.sentence for each in checked.findings]
    top = 2 if delimiter != ";" else 3  # of the rows, counted as they are put in
    below = [place for place in places if place >= top or place < 0]
    if delimiter == "\t":  # white space, as blank lines
        assert told == []
    else:
        (one,) = told
        assert one == notes[0]
        assert "empty rows, of separators only, were left out" in one
        assert (f"in {len(below)} rows" in one) is (len(below) > 1)
        with pytest.warns(Notice, match="of separators only") as caught:
            load_campaign(tmp_path)
        assert len(caught) == 1
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", Notice)
        (recording,) = load_campaign(tmp_path).recordings
    np.testing.assert_allclose(recording.t, T, atol=1e-6)
    np.testing.assert_allclose(recording.phi1, A, atol=1e-7)


def test_a_row_whose_time_alone_is_there_is_a_fault(lines, tmp_path):
    assert "remove the row" in spoilt(tmp_path, [*lines[:900], "3.6,,", *lines[901:]])


def test_lines_skipped_are_counted_as_they_stand(lines, tmp_path):
    rows = ["bench 3,,", ",,", "250 Hz,,", ",,", *lines, ",,"]
    (tmp_path / "a.csv").write_text("\n".join(rows) + "\n")
    write_toml(tmp_path, {"a.csv": OMEGA}, "[format]\nskip_lines = 4")
    with pytest.warns(Notice, match="in line 2506"):
        (recording,) = load_campaign(tmp_path).recordings
    assert recording.n == T.size


def test_a_file_of_separators_only(tmp_path):
    (tmp_path / "a.csv").write_text(",,\n,,\n")
    write_toml(tmp_path, {"a.csv": OMEGA})
    assert len(check(tmp_path).wrong) == 1
