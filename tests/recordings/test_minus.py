"""Columns that are counted from others."""

import numpy as np
import pytest

from tp_jax.recordings import CampaignError, load_campaign

T = np.arange(100) / 250.0
PHI1, PHI2 = 0.5 * np.sin(13.0 * T), 0.3 * np.sin(13.0 * T - 0.4)
BESIDE = "columns = {{ {} }}"


def campaign(folder, form: str, beside: str = "", header: str = "t,phi1,phi2"):
    rows = [f"{x:.9g},{y:.12g},{y + z:.12g}" for x, y, z in zip(T, PHI1, PHI2, strict=True)]
    (folder / "a.csv").write_text("\n".join([header, *rows]) + "\n")
    (folder / "campaign.toml").write_text(
        f"[format.columns]\n{form}\n[[recording]]\nfile = 'a.csv'\nforced = false\n{beside}\n"
    )
    return folder


MAPPED = "t = { column = 't' }\nphi1 = { column = 'phi1' }\nphi2 = { column = 'phi2', minus = %s }"


@pytest.mark.parametrize("minus", ["'base'", "'phi2'"])
@pytest.mark.parametrize(
    ("form", "beside"),
    [
        ("phi2 = { minus = %s }", ""),
        ("", "columns = { phi2 = { minus = %s } }"),
        (MAPPED, ""),
    ],
)
def test_minus_of_no_other_column_is_refused(form, beside, minus, tmp_path):
    fill = [text % minus if text else "" for text in (form, beside)]
    with pytest.raises(CampaignError) as caught:
        load_campaign(campaign(tmp_path, *fill))
    name = minus.strip("'")
    assert f'minus of phi2 is "{name}", which is no other column of [' in str(caught.value)
    assert 'write minus = "phi1"' in str(caught.value)
    right = [text % "'phi1'" if text else "" for text in (form, beside)]
    (recording,) = load_campaign(campaign(tmp_path, *right)).recordings
    np.testing.assert_allclose(recording.phi2, PHI2, atol=1e-9)


def test_minus_of_a_column_that_the_file_lacks_is_refused(tmp_path):
    with pytest.raises(CampaignError, match=r'a\.csv, line 1: minus of phi2 is "drive", a column'):
        load_campaign(campaign(tmp_path, "phi2 = { minus = 'drive' }"))
    header = "t,drive,phi2"  # it is there, but phi1 is not
    with pytest.raises(CampaignError, match='no column "phi1"'):
        load_campaign(campaign(tmp_path, "phi2 = { minus = 'drive' }", header=header))


def test_minus_of_a_column_that_is_not_wanted_itself(tmp_path):
    """The base against the rider, and the rider's own is taken from a third sensor."""
    rows = [
        f"{x:.9g},{y + z + 1.0:.12g},{z + 1.0:.12g},1"
        for x, y, z in zip(T, PHI1, PHI2, strict=True)
    ]
    campaign(tmp_path, "phi1 = { minus = 'phi2' }\nphi2 = { minus = 'drive' }")
    (tmp_path / "a.csv").write_text("\n".join(["t,phi1,phi2,drive", *rows]) + "\n")
    toml = tmp_path / "campaign.toml"
    toml.write_text(f"[rig]\nmodel = 'single'\n{toml.read_text()}")
    (recording,) = load_campaign(tmp_path).recordings
    np.testing.assert_allclose(recording.phi1, PHI1, atol=1e-9)
