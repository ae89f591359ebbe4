"""Cells in quotes: what is in them belongs together."""

import numpy as np
import pytest

from tp_jax.checks.proposal import propose
from tp_jax.recordings import CampaignError, FileFormat, load_campaign, read_columns
from tp_jax.recordings.cells import split

T = np.arange(200) / 250.0
PHI1, PHI2 = 0.5 * np.sin(13.0 * T), 0.3 * np.sin(13.0 * T - 0.4)


def quoted(value: float, digits: int) -> str:
    """A number as Excel writes it into a file with commas between cells: 1,5 in quotes."""
    cell = f"{value:.{digits}f}".rstrip("0").rstrip(".").replace(".", ",")
    return f'"{cell}"' if "," in cell else cell


def is_read(values) -> None:
    np.testing.assert_allclose(values["t"], T, atol=1e-9)
    np.testing.assert_allclose(values["phi1"], PHI1, atol=1e-9)
    np.testing.assert_allclose(values["phi2"], PHI2, atol=1e-9)


def text(header: str = "t,phi1,phi2", between: str = ",") -> str:
    rows = [
        between.join([quoted(x, 3), quoted(y, 12), quoted(z, 12)])
        for x, y, z in zip(T, PHI1, PHI2, strict=True)
    ]
    return "\n".join([header, *rows]) + "\n"


@pytest.mark.parametrize("header", ["t,phi1,phi2", '"t","phi1","phi2"', '"t [s]","phi1","phi2"'])
@pytest.mark.parametrize("between", [",", ", "])
def test_decimal_commas_in_quotes_between_commas(header, between, tmp_path):
    (tmp_path / "a.csv").write_text(text(header, between))
    is_read(read_columns(tmp_path / "a.csv").values)


@pytest.mark.parametrize("form", [FileFormat(delimiter=","), FileFormat(decimal=",")])
def test_one_of_the_two_commas_may_be_said(form, tmp_path):
    (tmp_path / "a.csv").write_text(text())
    is_read(read_columns(tmp_path / "a.csv", form).values)


def test_both_commas_may_be_said_as_init_does(tmp_path):
    (tmp_path / "a.csv").write_text(text())
    toml, _ = propose(tmp_path)
    assert 'delimiter = ","\ndecimal = ","' in toml
    (tmp_path / "campaign.toml").write_text(toml)
    (recording,) = load_campaign(tmp_path).recordings
    is_read({"t": recording.t, **recording.channels})


def test_both_commas_without_quotes_are_refused(tmp_path):
    (tmp_path / "a.csv").write_text(text().replace('"', ""))
    with pytest.raises(CampaignError, match=r'a\.csv: delimiter and decimal are both ","'):
        read_columns(tmp_path / "a.csv", FileFormat(delimiter=",", decimal=","))


def test_a_remark_with_commas_parts_nothing(tmp_path):
    rows = [
        f'{x:.9g},"{note}",{y:.12g},{z:.12g}'
        for x, y, z, note in zip(T, PHI1, PHI2, ["warm, dry", "ok"] * 100, strict=True)
    ]
    (tmp_path / "a.csv").write_text("\n".join(["t,remark,phi1,phi2", *rows]))
    is_read(read_columns(tmp_path / "a.csv").values)


@pytest.mark.parametrize(
    ("line", "delimiter", "cells"),
    [
        ('"0,004","1,23","0,5"', ",", ["0,004", "1,23", "0,5"]),
        ('"0,004", "1,23"', ",", ["0,004", "1,23"]),
        ('"a ""b"", c",1', ",", ['a "b", c', "1"]),
        ('"a,b",2"', ",", ["a", "b", "2"]),  # one quote too many: nobody can tell
        ('DEF="Zeit" t / s\t"winkel" w / rad', "\t", ['DEF="Zeit" t / s', 'winkel" w / rad']),
        ('2" pipe,3', ",", ['2" pipe', "3"]),
        ('"1" "2"', None, ["1", "2"]),
    ],
)
def test_cells_of_a_line(line, delimiter, cells):
    assert split(line, delimiter) == cells


def test_a_very_long_cell_in_quotes_is_no_fault_of_ours():
    assert len(split('"' + "a,b" * 100_000 + '",1', ",")) > 1
