"""What recordings and campaigns print is a line, whatever they hold."""

import numpy as np

from tp_jax.checks import check
from tp_jax.recordings import Campaign, Recording, load_campaign, read_columns
from tp_jax.recordings.short import short


def test_a_recording_and_a_campaign_print_a_line(campaign_folder):
    campaign = load_campaign(campaign_folder)
    assert repr(campaign) == (
        "Campaign('small', double, B1=0.0012, recordings=['decay.csv', 'run-06.csv', 'run-13.csv', "
        "'run-17.csv'])"
    )
    decay, driven, *_ = campaign.recordings
    assert repr(decay) == (
        "Recording('decay.csv', phi1 and phi2, 500 samples in 1.996 s, free decay)"
    )
    assert "omega=6" in repr(driven)


def test_a_large_campaign_too():
    t = np.linspace(0.0, 10.0, 900)  # NumPy prints all of up to a thousand
    runs = [{"t": t, "phi1": np.sin(3.0 * t + i), "omega": 3.0} for i in range(40)]
    campaign = Campaign.from_arrays(runs)
    assert len(repr(campaign)) < 200
    assert "... 40 in all" in repr(campaign)


def test_what_is_read_and_checked(campaign_folder):
    assert "array" not in repr(check(campaign_folder))
    assert len(repr(check(campaign_folder))) < 2000
    columns = read_columns(campaign_folder / "run-13.csv")
    assert "array(500)" in repr(columns)
    assert len(repr(columns)) < 1000


def test_measured_drives_and_held_out(recording):
    t = np.linspace(0.0, 4.0, 400)
    run = Recording.from_arrays(t, np.sin(t), drive=np.sin(t), held_out=True)
    assert repr(run).endswith("measured drive, held out)")
    assert "phi1 and phi2" in repr(recording())


def test_short():
    assert short([1, np.zeros(3), np.array([2.0])]) == "[1, array(3), [2.]]"
    assert short(tuple(range(9))) == "(0, 1, 2, 3, 4, 5, ... 9 in all)"
    assert len(short("x" * 500)) < 90
