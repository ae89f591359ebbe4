"""Times on a clock that began long before the run."""

import numpy as np
import pytest

from tests.made_runs import OMEGA, made_run, write_toml
from tp_jax.checks import check
from tp_jax.errors import Notice
from tp_jax.recordings import CampaignError, Recording, load_campaign

T, A, B = made_run()
EPOCH = 1_764_151_200.0


def write(folder, cells: list[str], form: str = ""):
    rows = [f"{t},{a:.9g},{b:.9g}" for t, a, b in zip(cells, A, B, strict=True)]
    (folder / "a.csv").write_text("\n".join(["t,phi1,phi2", *rows]) + "\n")
    write_toml(folder, {"a.csv": OMEGA}, form)
    return folder


@pytest.mark.parametrize(
    ("cells", "form"),
    [
        ([f"{EPOCH + x:.3f}" for x in T], ""),
        ([f"{EPOCH + 0.1234567 + x:.7f}" for x in T], ""),
        ([f"{1e3 * (EPOCH + x):.0f}" for x in T], "[format.columns]\nt = { unit = 'ms' }"),
        ([f"{x - EPOCH:.3f}" for x in T], ""),
    ],
)
def test_times_since_a_date_count_from_the_first_row(cells, form, tmp_path):
    checked = check(write(tmp_path, cells, form))
    assert checked.wrong == ()
    (mended,) = [each.sentence for each in checked.findings if each.level == "mended"]
    assert "a.csv: times begin at " in mended
    assert "were counted from the first row" in mended
    with pytest.warns(Notice, match="from the first row"):
        (recording,) = load_campaign(tmp_path).recordings
    assert recording.t[0] == 0.0
    np.testing.assert_allclose(recording.t, T, atol=1e-6)


@pytest.mark.parametrize("begin", [0.0, -3.0, 86_000.0, 1e6])
def test_times_of_a_day_or_of_a_board_stay(begin, tmp_path):
    (recording,) = load_campaign(write(tmp_path, [f"{begin + x:.3f}" for x in T])).recordings
    assert recording.t[0] == begin
    assert recording.notes == ()


def test_a_repeated_time_since_a_date_is_one_still(tmp_path):
    cells = [f"{EPOCH + x:.3f}" for x in np.where(T == T[70], T[69], T)]
    (wrong,) = check(write(tmp_path, cells)).wrong
    assert "line 72: the time 0.276 s is repeated; remove one of the two rows" in wrong.sentence


def test_a_fall_of_times_since_a_date_is_told(tmp_path):
    cells = [f"{EPOCH + x:.3f}" for x in np.where(T < 5.0, T, T - 2.0)]
    with pytest.raises(CampaignError, match=r"runs backwards from 4\.996 to 3 s"):
        load_campaign(write(tmp_path, cells))


def test_arrays_too():
    recording = Recording.from_arrays(EPOCH + T, A, B, omega=OMEGA)
    np.testing.assert_allclose(recording.t, T, atol=1e-6)
    (note,) = recording.notes
    assert note.startswith("run: times begin at 1764151200 s")
