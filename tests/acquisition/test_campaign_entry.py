"""Entries appended to a campaign.toml that is the user's own."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from tp_jax.acquisition.campaign_entry import (
    append_entry,
    check_campaign,
    free_name,
    unusable,
)
from tp_jax.acquisition.run_log import Recorded, metadata_path
from tp_jax.errors import InputError
from tp_jax.recordings import load_campaign, write_csv

OWN = """\
# the rig in room 3
name = "room 3"   # do not change
[rig]
B1 = 1.2e-3
[[recording]]
file = "decay.csv"
forced = false
# a remark at the end"""


def recorded(path, omega=13.09, state="complete", rows=500, release=None, clock=None):
    t = np.arange(rows) / 1000 / (1.0 + (clock["skew"] if clock else 0.0))
    if not path.exists():
        write_csv(path, t, 0.3 * np.sin(20 * t), 0.1 * np.sin(9 * t))
    metadata = {
        "samples": {"written": rows},
        "columns": ["t", "phi1", "phi2"],
        "device": {"rate": 1000.0},
        "drive": {"release": release},
        "clock": clock,
    }
    return Recorded(path, state, omega, omega is not None, t[-1], metadata)


def test_a_new_campaign(tmp_path):
    folder = tmp_path / 'a "rig"'
    check_campaign(folder)
    folder.mkdir()
    for omega, release in ((13.09, None), (13.09, None), (None, 0.5), (7.0, None)):
        path = free_name(folder, omega)
        assert append_entry(folder, recorded(path, omega, release=release)) is None
        check_campaign(folder)
    campaign = load_campaign(folder)
    assert campaign.name == 'a "rig"'
    assert campaign.model == "double"
    assert campaign.sample_rate == 1000.0
    assert [(each.name, each.omega, each.forced) for each in campaign.recordings] == [
        ("run-13.09.csv", 13.09, True),
        ("run-13.09-2.csv", 13.09, True),
        ("decay.csv", None, False),
        ("run-7.csv", 7.0, True),
    ]
    assert "# released at 0.5 rad" in (folder / "campaign.toml").read_text()


def test_the_rate_is_that_of_the_times(tmp_path):
    """Which were put right where the rig's clock is wrong."""
    clock = {"skew": 0.08, "applied": True}
    for omega in (13.09, 7.0):
        made = recorded(free_name(tmp_path, omega), omega, clock=clock)
        assert append_entry(tmp_path, made) is None
    assert load_campaign(tmp_path).sample_rate == 1080.0


@pytest.mark.parametrize("ends", ["\n", "\r\n"])
@pytest.mark.parametrize("last", ["", "\n", "\n\n"])
def test_what_the_user_wrote_stays_byte_for_byte(ends, last, tmp_path):
    file = tmp_path / "campaign.toml"
    before = (OWN + last).replace("\n", ends).encode()
    file.write_bytes(before)
    recorded(tmp_path / "decay.csv")
    assert append_entry(tmp_path, recorded(tmp_path / "run.csv", 13.092618)) is None
    after = file.read_bytes()
    assert after.startswith(before)
    assert (b"\r\n" in after[len(before) :]) is (ends == "\r\n")
    campaign = load_campaign(tmp_path)
    assert campaign.name == "room 3"
    assert campaign.recordings[1].omega == 13.092618
    assert not list(tmp_path.glob(".*"))


def test_a_short_or_interrupted_recording(tmp_path):
    assert append_entry(tmp_path, recorded(tmp_path / "run.csv", rows=49))
    assert not (tmp_path / "campaign.toml").exists()
    assert append_entry(tmp_path, recorded(tmp_path / "b.csv", state="unplugged")) is None
    assert "# unplugged after 0.499 s" in (tmp_path / "campaign.toml").read_text()


def test_a_recording_that_would_keep_the_campaign_from_being_read(tmp_path):
    good = recorded(tmp_path / "run.csv")
    assert unusable(tmp_path, good) is None
    assert append_entry(tmp_path, good) is None
    before = (tmp_path / "campaign.toml").read_bytes()
    t = np.arange(500) / 1000
    noise = 1e-3 * np.random.default_rng(0).normal(size=500)
    write_csv(tmp_path / "still.csv", t, noise, noise)
    still = recorded(tmp_path / "still.csv", None)
    write_csv(tmp_path / "slow.csv", 2.0 * t, 0.3 * np.sin(20 * t), noise)
    slow = recorded(tmp_path / "slow.csv")
    short = recorded(tmp_path / "short.csv", rows=49)
    for each, part in ((still, "does not move"), (slow, "sample_rate"), (short, "49 samples")):
        assert part in unusable(tmp_path, each)
        assert part in append_entry(tmp_path, each)
    assert (tmp_path / "campaign.toml").read_bytes() == before
    # in a campaign of its own the slow one is as good as any
    assert unusable(tmp_path / "new", slow) is None


def test_recordings_that_end_together_are_all_added(tmp_path):
    made = [recorded(tmp_path / f"run-{i}.csv") for i in range(6)]
    with ThreadPoolExecutor(len(made)) as pool:
        assert set(pool.map(lambda each: append_entry(tmp_path, each), made)) == {None}
    names = {each.name for each in load_campaign(tmp_path).recordings}
    assert names == {each.path.name for each in made}


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("name = ", "cannot be appended"),
        ('recording = "none"', "cannot be appended"),
        ("recording = [{ file = 'a.csv' }]", "cannot be appended"),
        ("[format]\nskip_lines = 3", "[format]"),
    ],
)
def test_a_campaign_that_cannot_take_it(text, part, tmp_path):
    file = tmp_path / "campaign.toml"
    file.write_text(text)
    with pytest.raises(InputError) as told:
        check_campaign(tmp_path)
    assert part in str(told.value)
    with pytest.raises(InputError):
        append_entry(tmp_path, recorded(tmp_path / "run.csv"))
    assert file.read_text() == text


def test_places_that_are_no_folder(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="no folder"):
        check_campaign(tmp_path / "file")
    (tmp_path / "campaign.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(InputError, match="UTF-8"):
        check_campaign(tmp_path)


def test_names_that_are_taken(tmp_path):
    assert free_name(tmp_path, 13.09) == tmp_path / "run-13.09.csv"
    metadata_path(tmp_path / "run-13.09.csv").write_text("{}")
    assert free_name(tmp_path, 13.09).name == "run-13.09-2.csv"
    Path(tmp_path / "decay.csv").symlink_to("nowhere")
    assert free_name(tmp_path, None).name == "decay-2.csv"
