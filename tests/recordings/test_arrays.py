"""Recordings and campaigns without files."""

import numpy as np
import pytest

import tp_jax as tp
from tp_jax.errors import InputError
from tp_jax.recordings import Campaign, Known, Recording

T = np.arange(500) / 250.0
PHI1, PHI2 = 0.5 * np.sin(13.0 * T), 0.3 * np.sin(13.0 * T - 0.4)


def test_a_recording_of_arrays():
    recording = Recording.from_arrays(T, PHI1, PHI2, omega=13.0, name="a", held_out=True)
    assert (recording.name, recording.forced, recording.omega) == ("a", True, 13.0)
    assert recording.held_out
    np.testing.assert_array_equal(recording.phi2, PHI2)
    assert len(recording.sha256) == 64


def test_units_and_dates():
    degrees = Recording.from_arrays(1e3 * T, np.degrees(PHI1), t_unit="ms", angle_unit="deg")
    assert not degrees.forced
    np.testing.assert_allclose(degrees.t, T, rtol=1e-14)
    np.testing.assert_allclose(degrees.phi1, PHI1, rtol=1e-13)
    dates = np.datetime64("2026-11-23T10:00") + (1e9 * T).round().astype("timedelta64[ns]")
    np.testing.assert_allclose(Recording.from_arrays(dates, PHI1).t, T, atol=1e-9)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        (dict(phi1=PHI1[:-1]), "one length"),
        (dict(phi1=np.degrees(PHI1)), "degrees"),
        (dict(phi1=np.zeros(500)), "does not move"),
        (dict(t=T[::-1]), "runs backwards"),
        (dict(t=T[:9], phi1=PHI1[:9]), "9 samples"),
        (dict(forced=True), "omega is None"),
        (dict(omega=-3.0), "omega is -3"),
        (dict(t_unit="fortnight"), "must be one of s, ms"),
        (dict(phi1=np.where(T == T[7], np.nan, PHI1)), "phi1 is nan"),
    ],
)
def test_arrays_that_cannot_be(given, says):
    with pytest.raises(InputError, match=says):
        Recording.from_arrays(**{"t": T, "phi1": PHI1, **given})


def test_a_campaign_of_arrays():
    runs = [dict(t=T, phi1=PHI1, phi2=PHI2, omega=13.0), dict(t=T, phi1=PHI1, phi2=PHI2)]
    campaign = Campaign.from_arrays(runs, name="rig", B1=1.2e-3, k=0.45, B2=(5e-4, 1e-5))
    assert campaign.model == "double"
    assert [r.label for r in campaign.recordings] == ["run-01", "run-02"]
    assert (campaign.k, campaign.B2) == (Known(0.45), Known(5e-4, 1e-5))
    assert tp.check is not None
    single = Campaign.from_arrays([Recording.from_arrays(T, PHI1)])
    assert single.model == "single"


@pytest.mark.parametrize(
    ("runs", "given", "says"),
    [
        ([], {}, "no recordings"),
        ([dict(t=T, phi1=PHI1)], dict(model="double"), "has no phi2"),
        ([dict(t=T, phi1=PHI1, phi2=PHI2), dict(t=T, phi1=PHI1)], {}, "run-02 has no phi2"),
        ([dict(t=T, phi1=PHI1, name="a"), dict(t=T, phi1=PHI1, name="a")], {}, "two recordings a"),
        ([dict(t=T, phi1=PHI1, held_out=True)], {}, "nothing to fit"),
        ([dict(t=T, phi1=PHI1)], dict(k=1.0), "B1 is not"),
    ],
)
def test_campaigns_that_cannot_be(runs, given, says):
    with pytest.raises(InputError, match=says):
        Campaign.from_arrays(runs, **given)


def test_frames_in_and_out():
    pandas = pytest.importorskip("pandas")
    recording = Recording.from_arrays(T, PHI1, PHI2, omega=13.0)
    frame = recording.to_frame()
    assert list(frame.columns) == ["t", "phi1", "phi2"]
    again = Recording.from_frame(frame, omega=13.0)
    assert again.sha256 == recording.sha256
    renamed = frame.rename(columns={"phi1": "column"})
    assert Recording.from_frame(renamed, {"phi1": "column"}).forced is False
    with pytest.raises(InputError, match="no column 'phi1'"):
        Recording.from_frame(renamed)
    assert isinstance(frame, pandas.DataFrame)
