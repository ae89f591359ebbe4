"""The model of a proposed campaign: columns that most files have."""

from tests.made_runs import made_run, write_rows
from tp_jax.checks.proposal import alike, data_files, propose
from tp_jax.checks.survey import survey

T, A, B = made_run()


def test_a_file_with_one_angle_that_comes_first_makes_no_single_pendulum(tmp_path):
    cells = [f"{x:.6f}" for x in T]
    write_rows(tmp_path / "a-calibration.csv", "t,phi1", cells, A)
    for name in ("b.csv", "c.csv"):
        write_rows(tmp_path / name, "t,phi1,phi2", cells, A, B)
    text, told = propose(tmp_path)
    assert "single" not in text
    assert 'file = "b.csv"' in text
    assert 'file = "c.csv"' in text
    (left_out,) = [each for each in told if each.startswith("Left out")]
    assert "a-calibration.csv" in left_out
    assert "differ from those of b.csv" in left_out
    # of as many, the ones with more columns; and those of a file that is named
    pairs = [(file, survey(file)) for file in data_files(tmp_path)]
    assert list(alike(pairs[:2])[1]) == [tmp_path / "a-calibration.csv"]
    assert list(alike(pairs, pairs[0])[1]) == [tmp_path / "b.csv", tmp_path / "c.csv"]
