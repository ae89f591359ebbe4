"""Rough rigs: differ from case to case, are usable, are recorded as they say."""

import dataclasses
import json
import math
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from scripts._blind.__main__ import main
from tp_jax.errors import InputError
from tp_jax.recordings import load_campaign
from tp_jax.rig import BENCH
from tp_jax.rig.effects import catalogue
from trials import make
from trials.plan import ROUGH_PARTS, counts, plan_cases
from trials.projection import Bench, noncentralities
from trials.recorder import DriveSensor, Recorder, Sensor
from trials.rough import (
    RoughSettings,
    draw_kind,
    draw_parameters,
    draw_recorder,
)
from trials.rough_case import bench_of, tellable
from trials.rough_runs import center, draw_runs, sealed_runs, shows
from trials.sealed_runs import nuisances

SHORT = RoughSettings(
    rates=(60.0, 120.0), recordings=(2, 3), durations=(3.0, 4.0), looked_at=1, per_run=1
)
ROUGH = RoughSettings()
SENSOR = Sensor(1e-3)


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    root = tmp_path_factory.mktemp("rough") / "trial"
    make(root, 4, 2, rigs="rough", settings=SHORT)
    return root


def key_of(root: Path) -> dict:
    return json.loads((root / "sealed" / "key.json").read_text())


def drawn(n: int = 300):
    rng = np.random.default_rng(0)
    for _ in range(n):
        kind = draw_kind(rng, ROUGH)
        p = draw_parameters(rng, ROUGH, kind)
        runs = draw_runs(rng, ROUGH, kind, p)
        recorder = draw_recorder(rng, ROUGH, kind, p.A)
        yield kind, p, recorder, runs, sealed_runs(rng, ROUGH, kind, runs)


def test_kinds_in_proportion():
    assert counts(360, ROUGH_PARTS) == ROUGH_PARTS
    plan = plan_cases(360, 3, "rough")
    assert Counter(case.kind for case in plan) == ROUGH_PARTS
    known = catalogue()
    for case in plan:
        if case.kind == "cousin":
            assert all(known[id].cousin_of for id in case.preferred)
            assert case.wanted == 1
        if case.kind == "outside":
            assert not any(known[id].cousin_of or known[id].in_catalogue for id in case.preferred)
    assert {case.seed for case in plan}.isdisjoint(case.seed for case in plan_cases(360, 3))
    with pytest.raises(InputError, match="clean or rough, not 'dirty'"):
        plan_cases(3, 0, "dirty")


def test_a_rough_trial(made):
    key = key_of(made)
    assert key["rigs"] == "rough"
    assert sorted(entry["kind"] for entry in key["cases"]) == ["cousin", "none", "one", "outside"]
    for entry in key["cases"]:
        given, recorder = entry["given"], entry["given"]["recorder"]
        campaign = load_campaign(made / entry["case"])
        assert campaign.data_sha256 == entry["sha256"]
        assert len(campaign.recordings) == len(given["runs"])
        assert (campaign.B1 is not None) == recorder["with_B1"]
        assert (campaign.model == "double") == (given["parameters"]["B2"] > 0.0)
        unit = 1.0 if recorder["with_B1"] else given["parameters"]["B1"]
        assert entry["unit_torque"] == unit
        for r, run in zip(campaign.recordings, given["runs"], strict=True):
            assert r.forced == ("omega" in run)
            assert r.n == round(run["duration"] * recorder["rate"]) + 1
            assert not r.forced or r.measured_drive == (recorder["drive"] is not None)
        assert entry["sealed"]["recorder"] == recorder
        assert entry["sealed"]["effects"] == given["effects"]
        assert len(load_campaign(made / "sealed" / entry["case"]).recordings) == 3
        if entry["kind"] == "cousin":
            ((id, told),) = entry["cousins"].items()
            assert told["of"] == catalogue()[id].cousin_of
        toml = (made / entry["case"] / "campaign.toml").read_text()
        assert not any(word in toml for word in (*catalogue(), "seed", "effect", "gain"))


@pytest.mark.slow
def test_same_seed_same_trial(made, tmp_path):
    again = make(tmp_path / "again", 4, 2, rigs="rough", settings=SHORT)
    assert again in (made / "KEY.sha256").read_text()


def test_settings_of_the_other_rigs_are_refused(tmp_path):
    with pytest.raises(InputError, match="not those of clean"):
        make(tmp_path / "t", 2, settings=SHORT)
    assert main(["make", str(tmp_path / "t"), "--rigs", "dirty"]) == 2


def test_campaigns_differ():
    every = list(drawn())
    kinds = [kind for kind, *_ in every]
    share = {
        "single": np.mean([not k.rider for k in kinds]),
        "decays": np.mean([not k.driven for k in kinds]),
        "measured": np.mean([k.measured for k in kinds if k.driven]),
        "B1": np.mean([r.with_B1 for _, _, r, _, _ in every]),
    }
    expected = {"single": 0.25, "decays": 0.1, "measured": 0.25, "B1": 0.5}
    assert share == pytest.approx(expected, abs=0.1)
    for kind, p, recorder, runs, _ in every:
        assert 50.0 <= kind.rate <= 1000.0
        assert 2 <= len(runs) <= 12
        assert all(3.0 <= run["duration"] <= 60.0 for run in runs)
        assert sum(run["duration"] for run in runs) * kind.rate <= 1.1 * ROUGH.most_samples
        assert kind.driven == any("omega" in run for run in runs)
        assert kind.rate >= 10.0 * math.sqrt(p.k / p.B1) / (2.0 * math.pi)
        assert p.has_rider == kind.rider
        for sensor in (recorder.sensor1, recorder.sensor2):
            assert 2e-4 <= math.hypot(sensor.white, sensor.coloured) <= 3.01e-3
            assert 0.0 <= sensor.ar[0] / (1.0 - sensor.ar[1]) <= 0.8
            assert 10 <= sensor.bits <= 16
            assert sensor.zero
        if recorder.drive is not None:
            assert 1e-3 <= recorder.drive.noise / p.A <= 2e-2
    stiffness = np.log10([p.k for _, p, *_ in every])
    assert np.ptp(stiffness) > 3.5


def test_sealed_runs_are_of_other_excitation():
    for kind, _, _, runs, sealed in drawn(100):
        for name in ("omega", "release"):
            given = sorted(abs(run[name]) for run in runs if name in run)
            others = [abs(run[name]) for run in sealed if name in run]
            assert bool(given) >= bool(others)
            assert not set(given) & set(others)
            if others:
                outside = [x for x in others if not given[0] <= x <= given[-1]]
                assert len(outside) >= 1
        assert any("omega" in run for run in sealed) == kind.driven
        assert all(("swing" in run) == (kind.measured and "omega" in run) for run in sealed)


def test_rigs_that_show_nothing_are_refused():
    runs = [{"omega": 14.0, "duration": 4.0}, {"release": 0.6, "duration": 4.0}]
    assert shows(BENCH, runs, 1e-3)
    assert not shows(dataclasses.replace(BENCH, M1=1.0), runs, 1e-3)
    assert not shows(dataclasses.replace(BENCH, Ts1=1.0), runs, 1e-3)
    assert shows(dataclasses.replace(BENCH, B2=0.0), runs, 1e-3)
    assert not shows(BENCH, runs, 0.1)


def test_what_recordings_of_a_kind_can_tell():
    commanded = Recorder(100.0, SENSOR, SENSOR)
    metered = Recorder(100.0, SENSOR, SENSOR, DriveSensor(2.0, 0.5, 1e-3, 12))
    assert tellable("drive_harmonics", commanded, True, True)
    for id in ("drive_harmonics", "drive_backlash", "clock_skew"):
        assert not tellable(id, metered, True, True)
        assert not tellable(id, commanded, False, True)
    assert not tellable("contact_wear", commanded, True, False)
    assert not tellable("reaction_factor", commanded, True, True)
    assert tellable("bearing_drag", metered, True, False)


def test_how_a_measured_drive_is_to_be_read():
    zero = dataclasses.asdict(dataclasses.replace(SENSOR, zero=0.03))
    recorder = {"sensor1": zero, "drive": dataclasses.asdict(DriveSensor(-2.0, 0.5, 0.0, 12))}
    found = nuisances({"given": {"recorder": recorder}})
    # at the arm's zero the reading is the offset, and the column reads its zero
    assert found["gain"] * 0.5 + found["level"] == pytest.approx(0.03)
    assert nuisances({"given": {}}) == {"phase": 0.0, "zero1": 0.0}


PLAN = [{"omega": 12.0, "duration": 3.0}, {"release": 0.7, "duration": 4.0}]


def test_a_bench_is_a_part_of_its_campaign():
    recorder = Recorder(100.0, dataclasses.replace(SENSOR, coloured=1e-3, ar=(0.8, 0.0)), SENSOR)
    settings = dataclasses.replace(ROUGH, looked_for=3.5)
    bench = bench_of(BENCH, recorder, PLAN, settings, seed=1)
    assert any("omega" in run for run in bench.plan)
    assert bench.noise == pytest.approx(recorder.sensor1.slow)
    assert bench.weights is not None
    assert bench.weights[1] < 1.0
    assert bench.samples == pytest.approx(2 * 700, rel=0.01)
    assert bench.window == pytest.approx(3.0 * math.pi / center(BENCH))


def test_more_noise_hides_more():
    fine = Bench(BENCH, PLAN, rate=100.0, noise=1e-3, per_run=2)

    def shown(bench):
        return noncentralities(bench, "spring_asymmetry", (0.05,), {})[0].sum()

    assert shown(dataclasses.replace(fine, noise=2e-3)) == pytest.approx(0.25 * shown(fine))
    both = dataclasses.replace(fine, weights=(2.0, 2.0))
    assert shown(both) == pytest.approx(0.25 * shown(fine), rel=1e-3)
    other = dataclasses.replace(fine, weights=(1.0, 3.0))
    assert 0.1 * shown(fine) < shown(other) < shown(fine)
    # a part of the campaign stands for all of it
    assert shown(dataclasses.replace(fine, part=0.5)) == pytest.approx(2.0 * shown(fine))
    # drives of half the amplitude swing less
    swung = dataclasses.replace(fine, plan=[{**PLAN[0], "swing": 0.5}, PLAN[1]])
    assert shown(swung) < shown(fine)


def test_a_column_alone_shows_its_bearing():
    single = dataclasses.replace(BENCH, B2=0.0)
    bench = Bench(single, PLAN, rate=100.0, per_run=2)
    assert bench.samples == 700
    found, _ = noncentralities(bench, "bearing_drag", (1e-3,), {})
    assert found.shape == (2,)
    assert found.sum() > 10.0
