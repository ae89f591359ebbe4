"""Campaigns of virtual rigs: what is written, what the key says, what cannot be."""

import dataclasses
import json

import numpy as np
import pytest

from tp_jax.errors import InputError
from tp_jax.recordings import load_campaign, noise_levels
from tp_jax.rig import BENCH, VirtualRig, make_campaign
from tp_jax.rig.chain import measure
from tp_jax.rig.plan import plan_runs


def test_standard_campaign(tmp_path):
    key = make_campaign(tmp_path / "blind-07", effects={"contact_stribeck": 0.5}, seed=4)
    campaign = load_campaign(tmp_path / "blind-07")
    assert campaign.name == "blind-07"
    assert campaign.model == "double"
    assert campaign.B1 == pytest.approx(BENCH.B1)
    assert campaign.B2 is None
    assert len(campaign.recordings) == 6
    assert [r.forced for r in campaign.recordings] == [False] + [True] * 5
    for r, run in zip(campaign.recordings, key["runs"], strict=True):
        assert r.t.size == 2501
        assert r.t[-1] == 10.0
        assert r.omega == run.get("omega")
        assert r.name == run["file"]
    assert np.median(noise_levels(campaign.recordings), axis=0)[0] == pytest.approx(1e-3, rel=0.1)
    # the rider slides, but for the slowest run perhaps
    assert all(
        np.ptp(r.phi2) > 0.03 for r in campaign.recordings if r.omega != key["runs"][1]["omega"]
    )


def test_the_key_is_plain_and_complete(tmp_path):
    key = make_campaign(
        tmp_path, effects={"column_tilt": (0.004, -0.002)}, runs=3, duration=1.0, seed=1
    )
    assert json.loads(json.dumps(key, allow_nan=False)) == key
    hidden = key["effects"]["column_tilt"]
    assert hidden["sizes"] == {"a": 0.004, "b": -0.002}
    assert hidden["channel"] == "column"
    assert key["parameters"] == dataclasses.asdict(BENCH)


def test_the_files_do_not_tell(tmp_path):
    make_campaign(tmp_path / "x", effects={"sensor_crosstalk": 0.05}, runs=2, duration=1.0)
    assert sorted(f.name for f in (tmp_path / "x").iterdir()) == [
        "campaign.toml",
        "run-01.csv",
        "run-02.csv",
    ]
    assert "crosstalk" not in (tmp_path / "x" / "campaign.toml").read_text()


def test_readings_are_those_of_the_rig(tmp_path):
    effects = {"spring_asymmetry": 0.08}
    key = make_campaign(tmp_path, effects=effects, runs=3, duration=2.0, noise=0.0, bits=24, seed=2)
    for r, run in zip(load_campaign(tmp_path).recordings, key["runs"], strict=True):
        kind = {name: run[name] for name in ("omega", "release") if name in run}
        ideal = VirtualRig(effects=effects).run(r.t, **kind)
        np.testing.assert_allclose(np.stack([r.phi1, r.phi2], axis=1), ideal, atol=1e-6)


def test_values_of_runs_that_matter_only_relatively_have_mean_zero(tmp_path):
    key = make_campaign(
        tmp_path, effects={"contact_repeatability": 0.2}, runs=4, duration=1.0, seed=5
    )
    values = [run["values"]["contact_repeatability"][0] for run in key["runs"]]
    assert len(set(values)) == 4
    assert sum(values) == pytest.approx(0.0, abs=1e-15)


def test_same_seed_same_files(tmp_path):
    texts = []
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        make_campaign(
            tmp_path / name, effects={"drive_frequency": 0.3}, runs=2, duration=1.0, seed=seed
        )
        texts.append((tmp_path / name / "run-02.csv").read_bytes())
    assert texts[0] == texts[1]
    assert texts[0] != texts[2]


def test_column_alone(tmp_path):
    single = dataclasses.replace(BENCH, B2=0.0)
    make_campaign(tmp_path, single, {"bearing_drag": 1e-4}, runs=2, duration=1.0)
    campaign = load_campaign(tmp_path)
    assert campaign.model == "single"
    assert campaign.recordings[0].phi2 is None


def test_gives_B2_where_it_is_asked_to(tmp_path):
    make_campaign(tmp_path, runs=2, duration=1.0, with_B2=True)
    known = load_campaign(tmp_path).B2
    assert known is not None
    assert known.value == pytest.approx(BENCH.B2)


def test_clock_skew_is_in_the_stamps(tmp_path):
    kind = dict(runs=2, duration=2.0, noise=0.0, bits=24)
    key = make_campaign(tmp_path, effects={"clock_skew": 0.02}, **kind)
    r = load_campaign(tmp_path).recordings[1]
    np.testing.assert_allclose(np.diff(r.t), 1 / 250, rtol=1e-9)
    true = VirtualRig().run(r.t / 1.02, omega=key["runs"][1]["omega"])
    np.testing.assert_allclose(r.phi1, true[:, 0], atol=1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_rigs_of_other_sizes_slide_too(seed):
    rng = np.random.default_rng(seed)
    p = BENCH.scaled(rng, 0.3)
    plan = plan_runs(p, 6, rng)
    omegas = [kind["omega"] for kind in plan[1:]]
    assert omegas == sorted(omegas)
    assert len(set(omegas)) == 5
    rig = VirtualRig(p)
    slides = [np.ptp(rig.run(np.arange(751) / 250, **kind)[:, 1]) > 0.03 for kind in plan]
    assert sum(slides) >= 5


def test_noise_and_converter():
    rng = np.random.default_rng(0)
    phi = rng.uniform(-20.0, 20.0, 20_000)
    read = measure(phi, rng, noise=1e-3, bits=16)
    assert np.std(read - phi) == pytest.approx(1e-3, rel=0.03)
    assert np.abs(read - phi).max() < 6e-3
    # coarse, and no more: half a number of each bridge, out of 2^10 over 2.2 times full scale
    coarse = measure(phi, rng, noise=0.0, bits=10) - phi
    assert 1e-4 < np.abs(coarse).max() < 2.2 / 2**10


@pytest.mark.parametrize(
    ("given", "says"),
    [
        (dict(effects={"nonsense": 1.0}), "no effect 'nonsense'"),
        (dict(runs=1), "at least 2 runs"),
        (dict(rate=0.0), "too few samples"),
        (dict(noise=-1.0), "noise must be"),
        (dict(bits=2), "4 to 32 bits"),
    ],
)
def test_what_cannot_be_made_is_said_and_not_begun(tmp_path, given, says):
    with pytest.raises(InputError, match=says) as fault:
        make_campaign(tmp_path / "new", **given)
    assert "\n" not in str(fault.value)
    assert not (tmp_path / "new").exists()
