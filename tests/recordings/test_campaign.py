"""A campaign as it is meant to be."""

from pathlib import Path

import numpy as np
import pytest

from tp_jax.recordings import Known, hold_out, load_campaign, noise_levels

ROOT = Path(__file__).parents[2]
POHL_WHEEL = ROOT.parent / "shared" / "data" / "pohl_wheel"


@pytest.mark.parametrize("of", ["folder", "toml", "text"])
def test_folder_or_toml(of, campaign_folder):
    path = campaign_folder / "campaign.toml" if of == "toml" else campaign_folder
    campaign = load_campaign(str(path) if of == "text" else path)
    assert campaign.name == "small"
    assert campaign.model == "double"
    assert campaign.B1 == 1.2e-3
    assert campaign.B2 is campaign.k is None
    assert campaign.sample_rate == 250.0
    assert campaign.folder == campaign_folder
    assert campaign.channels == ("phi1", "phi2")
    assert campaign.fitted == campaign.recordings
    assert [each.label for each in campaign.recordings] == [
        "decay.csv",
        "run-06.csv",
        "run-13.csv",
        "run-17.csv",
    ]
    decay, *_, last = campaign.recordings
    assert (decay.forced, decay.omega) == (False, None)
    assert (last.forced, last.omega) == (True, 17.0)
    assert last.n == 500
    assert last.duration == pytest.approx(499 / 250)
    assert not last.measured_drive
    assert list(last.channels) == ["phi1", "phi2"]
    assert set(campaign.data_sha256) == {each.name for each in campaign.recordings}
    with pytest.raises(ValueError, match="read-only"):
        last.phi1[0] = 0.0


def test_everything_a_rig_and_an_entry_can_say(campaign_folder, edit):
    edit("campaign.toml", "B1 =", "B2 = 5e-4\nk = { value = 0.4, sd = 0.02 }\nB1 =")
    edit(
        "campaign.toml",
        "omega = 13.09",
        'omega = 13\nstart = 120\nrepeat = "A"\nheld_out = true\nspan = [0.5, 1.5]',
    )
    campaign = load_campaign(campaign_folder)
    assert campaign.B2 == Known(5e-4)
    assert campaign.k == Known(0.4, 0.02)
    (held,) = campaign.held_out
    assert held.label == held.name == "run-13.csv"
    assert (held.omega, held.repeat, held.span) == (13.0, "A", (0.5, 1.5))
    assert (held.t[0], held.t[-1], held.n) == (0.5, 1.5, 251)
    assert held.clock is not None
    assert held.clock[0] == 120.5
    assert hold_out(campaign) is campaign


def test_names_and_labels_of_two_spans(campaign_folder, edit):
    edit("campaign.toml", "omega = 13.09", "omega = 13.09\nspan = [0.0, 0.996]")
    edit("campaign.toml", "run-17.csv", "run-13.csv")
    edit("campaign.toml", "omega = 17.0", "omega = 17.0\nspan = [1, 2.5]\nheld_out = true")
    *_, first, second = load_campaign(campaign_folder).recordings
    assert first.name == second.name == "run-13.csv"
    assert (first.label, second.label) == ("run-13.csv[0,0.996]", "run-13.csv[1,2.5]")
    assert (first.n, second.n) == (250, 250)


def test_forced_is_known_without_saying(campaign_folder):
    path = campaign_folder / "campaign.toml"
    path.write_text(path.read_text().replace("forced = true", "").replace("forced = false", ""))
    assert [each.forced for each in load_campaign(path).recordings] == [False, True, True, True]


def test_absent_rig_and_name(campaign_folder):
    path = campaign_folder / "campaign.toml"
    path.write_text('[[recording]]\nfile = "decay.csv"\nforced = false\n')
    campaign = load_campaign(path)
    assert campaign.name == campaign_folder.name
    assert campaign.B1 is None


def test_phi2_is_ignored_on_a_single_pendulum(campaign_folder, edit, write_run, run_columns):
    t, phi1, phi2 = run_columns
    write_run("run-13.csv", "t,phi1,phi2", t, phi1, np.nan * phi2)
    edit("campaign.toml", "[rig]", '[rig]\nmodel = "single"')
    campaign = load_campaign(campaign_folder)
    assert campaign.model == "single"
    assert campaign.channels == ("phi1",)
    assert all(each.phi2 is None for each in campaign.recordings)


def test_faults_outside_the_span_do_not_matter(campaign_folder, edit, write_run, run_columns):
    t, phi1, phi2 = run_columns
    phi1[400] = np.nan
    write_run("run-13.csv", "t,phi1,phi2", t, phi1, phi2)
    edit("campaign.toml", "omega = 13.09", "omega = 13.09\nspan = [0.0, 1.5]")
    assert load_campaign(campaign_folder).recordings[2].n == 376


def test_ring_may_wind_without_limit(campaign_folder, write_run, run_columns):
    t, phi1, phi2 = run_columns
    write_run("run-13.csv", "t,phi1,phi2", t, phi1, phi2 + 100.0 * t)
    assert np.ptp(load_campaign(campaign_folder).recordings[2].channels["phi2"]) > 100.0


def test_single_file(campaign_folder):
    campaign = load_campaign(campaign_folder / "run-13.csv", omega=13.09)
    assert (campaign.name, campaign.model, campaign.B1) == ("run-13", "double", None)
    (recording,) = campaign.recordings
    assert (recording.forced, recording.omega) == (True, 13.09)
    (recording,) = load_campaign(campaign_folder / "decay.csv", decay=True).recordings
    assert (recording.forced, recording.omega) == (False, None)


def test_measured_drive(campaign_folder, edit, write_run, run_columns):
    t, phi1, phi2 = run_columns
    write_run("run-13.csv", "t,phi1,phi2,drive", t, phi1, phi2, np.cos(t))
    edit("campaign.toml", "omega = 13.09", 'drive = "measured"')
    recording = load_campaign(campaign_folder).recordings[2]
    assert recording.measured_drive
    assert (recording.forced, recording.omega) == (True, None)
    np.testing.assert_array_equal(recording.drive, np.cos(t))


def test_cut(recording):
    run = recording(drive=np.arange(500.0), start=10.0)
    part = run.cut(0.5, 1.0)
    assert part.label == "run.csv[0.5,1]"
    assert part.name == "run.csv"
    assert part.span == (0.5, 1.0)
    assert (part.t[0], part.t[-1]) == (0.5, 1.0)
    assert part.n == part.phi1.size == part.phi2.size == part.drive.size == 126
    assert part.clock[0] == 10.5
    with pytest.raises(ValueError, match=r"run\.csv has no sample in \[5, 6\] s"):
        run.cut(5.0, 6.0)


def test_example_that_comes_with_the_package():
    campaign = load_campaign(ROOT / "tp_jax" / "examples" / "case-02")
    assert campaign.model == "double"
    assert [each.name for each in hold_out(campaign).held_out] == ["run-17.csv"]
    assert np.median(noise_levels(campaign.recordings), axis=0) == pytest.approx(1e-3, rel=0.03)


@pytest.mark.skipif(
    not (POHL_WHEEL / "Cassy.txt").exists(),
    reason="the Pohl wheel's data are not part of the repository and not beside it",
)
def test_pohl_wheel():
    campaign = load_campaign(POHL_WHEEL)
    assert campaign.model == "single"
    fitted, held = campaign.recordings
    assert (fitted.label, held.label) == ("Cassy.txt[0,200]", "Cassy.txt[200,661]")
    assert fitted.n + held.n == 6609
    assert held.t[-1] == 660.83706
    assert held.held_out
    assert fitted.measured_drive
    assert fitted.phi1[0] == -1.42546245919478
    assert fitted.drive[0] == 0.0100000000000002
    # rounding alone is 0.00314
    assert 0.0031 < np.median(noise_levels([fitted, held]), axis=0)[0] < 0.0040
