"""The whole analysis of a small campaign: its form, and what it must say."""

import dataclasses
import json

import numpy as np
import pytest

from tests.sensitivity_analysis.conftest import SMALL
from tp_jax.cli.output import json_text
from tp_jax.errors import InputError
from tp_jax.identifiability.design import UNKNOWNS
from tp_jax.results.sensitivity import SensitivityRecord
from tp_jax.sensitivity_analysis.analysis import sensitivity

KEYS = {
    "schema",
    "identifiable",
    "null_directions",
    "correlation",
    "local",
    "sobol",
    "morris",
    "provenance",
}


@pytest.fixture(scope="module")
def result(analysis):
    return json.loads(json_text(analysis.to_dict()))


def test_form(result):
    assert result["schema"] == "tp-jax/sensitivity/1"
    assert set(result) >= KEYS
    assert list(result["identifiable"]) == list(UNKNOWNS)
    assert all(isinstance(x, bool) for x in result["identifiable"].values())
    names = result["correlation"]["parameters"]
    assert np.shape(result["correlation"]["matrix"]) == (len(names), len(names))
    for part in ("local", "sobol", "morris"):
        assert len(result[part]["recordings"]) == 3
        for r in result[part]["recordings"]:
            assert {"recording", "t", "phi1", "phi2"} <= set(r)


def test_what_is_written_is_read_again(analysis, result):
    again = SensitivityRecord.read(result)
    assert json.loads(json_text(again.to_dict())) == result
    assert again.identifiable == analysis.identifiable
    assert (
        again.sobol.recordings[0].channels["phi2"].total["k"]
        == result["sobol"]["recordings"][0]["phi2"]["ST"]["k"]
    )
    assert analysis.quality.chi2_dof == analysis.fit.chi2_dof
    assert "rank 9 of 11, not told: " in repr(analysis)


def test_what_can_be_known(result):
    known = result["identifiable"]
    assert all(known[n] for n in ("B1", "B2", "k", "A", "c1", "M1"))
    assert not known["Ts2"]
    assert result["structural"]["rank"] == 9


def test_the_scale_is_free_but_for_b1(result):
    structural = [d for d in result["null_directions"] if d["kind"] == "structural"]
    by_size = sorted(structural, key=lambda d: len(d["parameters"]))
    assert list(by_size[0]["parameters"]) == ["Ts2"]
    assert by_size[0]["removed_by"] is None
    assert set(by_size[1]["parameters"]) == {"B1", "B2", "k", "c1", "M1", "Tv", "Ts1", "Tst"}
    assert by_size[1]["removed_by"] == "B1 is given"


def test_through_time(result):
    for r in result["local"]["recordings"]:
        for channel in ("phi1", "phi2"):
            assert len(r[channel]["k"]) == len(r["t"])
            assert not any(r[channel]["Ts2"])
    for r in result["sobol"]["recordings"]:
        for channel in ("phi1", "phi2"):
            assert len(r[channel]["through_time"]["ST"]["k"]) == len(r["t"])
            assert r[channel]["ST"]["Ts2"] == 0.0


def test_profile(result):
    low, high = result["profile"]["k"]["ci95"]
    assert low < result["parameters"]["k"]["value"] < high


def test_summary(analysis):
    text = analysis.summary()
    assert "Rank 9 of 11" in text
    assert "Ts2 alone" in text
    assert "(B1 is given)" in text


def test_the_same_seed_gives_the_same(campaign, analysis):
    again = sensitivity(campaign, **SMALL, profile=("k",))
    first, second = (json.loads(json_text(a.to_dict())) for a in (analysis, again))
    for one in (first, second):
        one["provenance"].pop("wall_s")
    assert first == second


def test_without_b1_the_scale_stays_free(campaign):
    found = sensitivity(dataclasses.replace(campaign, B1=None), **SMALL).to_dict()
    assert not found["identifiable"]["B1"]
    assert found["identifiable"]["k"]  # relative to B1
    (scale,) = [d for d in found["null_directions"] if "B1" in d["parameters"]]
    assert scale["removed_by"] is None
    assert "B1" in found["sobol"]["ranges"]
    assert any(w["code"] == "free_scale" for w in found["warnings"])


def test_a_column_alone(campaign):
    single = dataclasses.replace(
        campaign,
        model="single",
        recordings=tuple(dataclasses.replace(r, phi2=None) for r in campaign.recordings),
    )
    found = sensitivity(single, **SMALL).to_dict()
    assert list(found["identifiable"]) == ["B1", "k", "A", "c1", "M1"]
    assert found["structural"]["rank"] == 4
    assert set(found["sobol"]["ST"]) == {"phi1"}


@pytest.mark.parametrize(
    ("options", "part"),
    [
        (dict(fix={"mass": 1.0}), "'mass'"),
        (dict(spread=1.0), "above 1"),
        (dict(samples=100), "power of two"),
        (dict(trajectories=1), "two trajectories"),
        (dict(points=0), "one point"),
    ],
)
def test_faults(campaign, options, part):
    with pytest.raises(InputError, match=part) as fault:
        sensitivity(campaign, **options)
    assert str(fault.value).endswith(".")


def test_a_measured_drive_and_a_decay_have_no_amplitude(campaign):
    """The motor's angle read as volts about 2.57 V; nothing is recorded of it in the decay."""
    decay, *driven = [dataclasses.replace(r, phi2=None) for r in campaign.recordings]
    assert not decay.forced
    runs = [
        dataclasses.replace(r, drive=2.57 + 0.5 * np.sin(r.omega * r.t), omega=None) for r in driven
    ]
    made = dataclasses.replace(campaign, model="single", recordings=(decay, *runs))
    found = sensitivity(made, **SMALL).to_dict()
    assert list(found["identifiable"]) == ["B1", "k", "c1", "M1", "gain"]
    # a change of the gain moves the column as the sine does; the mean reading, 5.1 times its
    # amplitude, does not turn it
    for r in found["local"]["recordings"][1:]:
        moved = np.array(r["phi1"]["gain"])
        assert abs(moved.mean()) < 0.3 * np.abs(moved).max()
    with pytest.raises(InputError, match="A is not fitted here, choose one of: k, c1, M1"):
        sensitivity(made, **SMALL, profile=("A",))


def test_where_nothing_is_free_nothing_is_varied(campaign):
    single = dataclasses.replace(
        campaign,
        model="single",
        recordings=tuple(dataclasses.replace(r, phi2=None) for r in campaign.recordings),
    )
    held = {"k": 0.45, "A": 0.18, "c1": 2.2e-3, "M1": 5e-3}
    with pytest.raises(InputError, match=r"All parameters of .* are held"):
        sensitivity(single, **SMALL, fix=held)
