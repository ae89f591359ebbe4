"""Lines of t phi1 phi2."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tp_jax.acquisition.parser import TextParser, numbers


@pytest.mark.parametrize(
    ("line", "row"),
    [
        (b"0.004 0.1 -0.2", [0.004, 0.1, -0.2]),
        (b"0.004,0.1,-0.2", [0.004, 0.1, -0.2]),
        (b" 0.004\t 1e-1 ;-0.2 ", [0.004, 0.1, -0.2]),
        (b"0.004 0.1", [0.004, 0.1]),
        (b"0.004 0.1 0.2 0.3", None),
        (b"0.004", None),
        (b"t phi1 phi2", None),
        (b"0.004 nan 0.1", None),
        (b"0.004 1e9 0.1", None),
        (b"0.004 0.1 -10001", None),
        (b"0.004 9999 0.1", [0.004, 9999.0, 0.1]),
        (b"999999 0.1 0.1", [999999.0, 0.1, 0.1]),
        (b"1e7 0.1 0.1", None),
        (b"0.004 inf 0.1", None),
        (b"0.0_4 1 0.1", None),
        (b"0.004 0.\xff 0.1", None),
        (b"", None),
    ],
)
def test_a_line(line, row):
    assert numbers(line) == row


@pytest.mark.parametrize("end", [b"\n", b"\r\n", b"\r"])
def test_a_stream(end):
    parser = TextParser()
    data = end.join(
        [b"7.5 3", b"# made by hand", b"0.1 1 2", b"", b"0.2 3 4", b"0.3 x 4", b"0.4 5"]
    )
    rows = parser.feed(data[:20])
    rows = np.concatenate([rows.reshape(-1, 3), parser.feed(data[20:] + end)])
    np.testing.assert_array_equal(rows, [[0.1, 1, 2], [0.2, 3, 4]])
    assert (parser.good, parser.corrupt, parser.columns) == (2, 2, 3)  # no number; a cell missing


def test_a_line_without_an_end():
    parser = TextParser()
    for _ in range(100):
        parser.feed(b"1" * 100)
    assert len(parser._rest) <= 256
    assert len(parser.feed(b"\n0.1 1 2\n")) == 1


@given(st.lists(st.binary(max_size=60), max_size=20))
def test_anything_goes_in(pieces):
    parser = TextParser()
    for piece in pieces:
        rows = parser.feed(piece)
        assert np.isfinite(rows).all()
