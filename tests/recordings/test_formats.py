"""Data files of all kinds give the columns that were written into them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tp_jax.recordings import ColumnSource, FileFormat, read_columns, write_csv

FINITE = st.floats(allow_nan=False, allow_infinity=False, width=64)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("formats")  # one for all of hypothesis's examples


@given(data=st.data(), n=st.integers(1, 20), double=st.booleans())
def test_round_trip_is_exact(folder, data, n, double):
    written = [data.draw(arrays(float, n, elements=FINITE)) for _ in range(3 if double else 2)]
    path = folder / "round.csv"
    write_csv(path, *written)
    read = read_columns(path)
    assert list(read.values) == ["t", "phi1", "phi2"][: len(written)]
    for old, new in zip(written, read.values.values(), strict=True):
        np.testing.assert_array_equal(new, old)
    assert read.header == 1
    assert list(read.numbers) == list(range(2, n + 2))


def test_written_header_and_digits(tmp_path):
    write_csv(tmp_path / "a.csv", [0.0, 0.1], [1.0, 1 / 3])
    assert (tmp_path / "a.csv").read_bytes() == (
        b"t,phi1\n0,1\n0.10000000000000001,0.33333333333333331\n"
    )


def test_writing_replaces_whole_files_only(tmp_path):
    path = tmp_path / "a.csv"
    write_csv(path, [0.0], [1.0])
    with pytest.raises(ValueError, match=r"of one length, but are t \(1,\), phi1 \(2,\)"):
        write_csv(path, [0.0], [1.0, 2.0])
    assert path.read_text() == "t,phi1\n0,1\n"
    write_csv(path, [5.0], [6.0], [7.0])
    assert path.read_text() == "t,phi1,phi2\n5,6,7\n"
    assert list(tmp_path.iterdir()) == [path]


def test_failed_write_leaves_nothing(tmp_path):
    (tmp_path / "a.csv").mkdir()
    with pytest.raises(OSError, match=r"a\.csv"):
        write_csv(tmp_path / "a.csv", [0.0], [1.0])
    assert [each.name for each in tmp_path.iterdir()] == ["a.csv"]


@pytest.mark.parametrize(
    "text",
    [
        "0.0 0.1 0.2\n0.004 1e-1 .2\n",  # the paper's
        "  0.0\t0.1   0.2  \n\n 0.004  0.1 0.2",
        "0.0,0.1,0.2\n0.004,0.1,0.2\n",
        "0.0, 0.1, 0.2\r\n0.004, 0.1, 0.2\r\n",
        "0.0,0.1,0.2,\n0.004,0.1,0.2,\n",
        "0.0,0.1,0.2\r0.004,0.1,0.2\r",
        "t,phi1,phi2\n0.0,0.1,0.2\n0.004,0.1,0.2\n",
        "# t,phi1,phi2\n0.0,0.1,0.2\n0.004,0.1,0.2\n",
        "t phi1 phi2\n0.0 0.1 0.2\n0.004 0.1 0.2\n",
        '"phi2", "t", "note", "phi1"\n0.2,0.0,first,0.1\n"0.2","0.004",second,"0.1"\n',
        "\ufefft,phi1,phi2\r\r\n0.0,0.1,0.2\r\r\n0.004,0.1,0.2\r\r\n",
    ],
)
def test_forms_without_a_format(text, tmp_path):
    path = tmp_path / "data.txt"
    path.write_bytes(text.encode())
    values = read_columns(path).values
    np.testing.assert_array_equal(values["t"], [0.0, 0.004])
    np.testing.assert_array_equal(values["phi1"], [0.1, 0.1])
    np.testing.assert_array_equal(values["phi2"], [0.2, 0.2])


def test_two_headerless_columns_are_a_single_pendulum(tmp_path):
    (tmp_path / "a.txt").write_text("0.0 0.1\n0.1 0.2\n")
    assert list(read_columns(tmp_path / "a.txt").values) == ["t", "phi1"]


def test_drive_column_is_read_when_wanted(tmp_path):
    (tmp_path / "a.csv").write_text("t,phi1,drive\n0,1,2\n")
    assert list(read_columns(tmp_path / "a.csv").values) == ["t", "phi1", "drive"]
    assert list(read_columns(tmp_path / "a.csv", wanted=("t", "phi1")).values) == ["t", "phi1"]


def test_another_makers_format(tmp_path):
    """Header lines, tabs, decimal comma, a byte-order mark, CR CR LF, and a blank line."""
    header = ["MIN=0\t-1\t-5", "MAX=905,09\t1\t5", "", 'DEF="Zeit" t / s\t"Weg"\t"winkel" w / rad']
    rows = ["0\t-0,131\t-1,4", "0,1\t-0,162\t-1,7"]
    path = tmp_path / "rig.txt"
    path.write_bytes(b"\xef\xbb\xbf" + "\r\r\n".join([*header, *rows, ""]).encode())
    form = FileFormat(
        delimiter="\t",
        decimal=",",
        skip_lines=3,
        columns={
            "t": ColumnSource(0, scale=1e-3),
            "phi1": ColumnSource('winkel" w / rad'),
            "drive": ColumnSource(1, scale=2.0, offset=-2.57),
        },
    )
    read = read_columns(path, form)
    np.testing.assert_array_equal(read.values["t"], [0.0, 1e-4])
    np.testing.assert_array_equal(read.values["phi1"], [-1.4, -1.7])
    np.testing.assert_allclose(read.values["drive"], [-2.832, -2.894], rtol=1e-15)
    assert list(read.numbers) == [5, 6]
    assert read.header == 4


def test_header_is_found_without_skip_lines(tmp_path):
    (tmp_path / "a.csv").write_text("time;angle\n0,5;1,5\n")
    form = FileFormat(decimal=",", columns={"t": ColumnSource("time"), "phi1": ColumnSource(1)})
    values = read_columns(tmp_path / "a.csv", form).values
    assert (values["t"][0], values["phi1"][0]) == (0.5, 1.5)


@pytest.mark.parametrize("encoding", ["utf-16", "latin-1"])
def test_other_encodings(encoding, tmp_path):
    (tmp_path / "a.csv").write_bytes("t,phi1,°C\n0.5,1.5,20\n".encode(encoding))
    assert read_columns(tmp_path / "a.csv").values["phi1"][0] == 1.5


def test_checksum(tmp_path):
    (tmp_path / "a.csv").write_bytes(b"t,phi1\n0,1\n")
    # sha256sum of the same bytes
    assert read_columns(tmp_path / "a.csv").sha256 == (
        "ba769e702c9c15b5b6d7946b57b1a058b4ca5f551e37bc3971135db3e1462906"
    )
