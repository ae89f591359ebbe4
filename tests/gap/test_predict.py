"""Predictions from the numbers of a fit."""

import dataclasses
import json

import numpy as np
import pytest

import tp_jax as tp
from tests.rigs import synthetic_campaign, synthetic_values
from tp_jax.effects import catalogue
from tp_jax.errors import InputError
from tp_jax.estimation.assemble import drive_for, fit_record, pendulum
from tp_jax.estimation.prepared_campaign import prepare_campaign
from tp_jax.recordings import write_csv
from tp_jax.results.diagnosis import ModelFit

ZERO1, ZERO2 = 0.05, -0.02  # rad


@pytest.fixture
def folder(tmp_path):
    """The synthetic campaign as files, its sensors' zeros off."""
    text = ['name = "off"', "[rig]", "B1 = 1.2e-3"]
    for r in synthetic_campaign(1e-5).recordings:
        write_csv(tmp_path / r.name, r.t, r.phi1 + ZERO1, r.phi2 + ZERO2)
        text += ["[[recording]]", f'file = "{r.name}"', f"forced = {str(r.forced).lower()}"]
        text += [f"omega = {r.omega}"] * r.forced
    (tmp_path / "campaign.toml").write_text("\n".join(text) + "\n", encoding="utf-8")
    return tmp_path


def diagnosis_of(**changes) -> dict:
    """One without a cause, by the true numbers."""
    setting = prepare_campaign(synthetic_campaign(1e-5), effects=())
    values = synthetic_values(setting).replace({"zero1": ZERO1, "zero2": ZERO2} | changes)
    record = fit_record(values, (), [r.label for r in setting.recordings])
    return {"fits": {"before": record, "after": None}}


def test_a_fitted_run_starts_from_its_angles_not_from_its_readings(folder):
    run = tp.predict(diagnosis_of(), recording=folder / "decay.csv", duration=0.5, rate=250.0)
    data = tp.load_campaign(folder).recordings[0]
    assert float(run.phi1[0]) == pytest.approx(data.phi1[0], abs=5e-3)
    np.testing.assert_allclose(run.phi1, data.phi1[:126], atol=2e-2)


@pytest.mark.parametrize(
    ("measured", "changes", "kind"), [(False, {"A": 0.0}, "commanded"), (True, {}, "measured")]
)
def test_a_drive_that_no_fitted_recording_had_is_not_predicted(tmp_path, measured, changes, kind):
    """As an undriven rig it would hardly move, and nobody would know why."""
    run = synthetic_campaign(1e-5).recordings[1]
    columns = [run.t, run.phi1, run.phi2, *([np.sin(13.0 * run.t)] if measured else [])]
    header = ",".join(["t", "phi1", "phi2", "drive"][: len(columns)])
    rows = [",".join(f"{x:.9g}" for x in row) for row in zip(*columns, strict=True)]
    (tmp_path / "run.csv").write_text("\n".join([header, *rows]) + "\n")
    how = 'drive = "measured"' if measured else "omega = 13.09"
    entry = f'[[recording]]\nfile = "run.csv"\nforced = true\n{how}\n'
    (tmp_path / "campaign.toml").write_text(f'name = "later"\n{entry}', encoding="utf-8")
    with pytest.raises(InputError, match=f"run.csv has a {kind} drive, .* knows nothing"):
        tp.predict(diagnosis_of(**changes), recording=tmp_path / "run.csv")


def test_a_start_that_lies_within_the_run_is_led_back_to_its_beginning(folder):
    """Of samples that were means of several, the first lies half of them later."""
    data = tp.load_campaign(folder).recordings[0]
    found = diagnosis_of()

    def start(at: float, state: list[float]):
        used = {"label": data.label, "sha256": data.sha256, "begin": at, "start": {"before": state}}
        asked = found | {"recordings": [used]}
        run = tp.predict(asked, recording=folder / "decay.csv", duration=0.5, rate=250.0)
        return float(run.phi1[0]), float(run.phi2[0])

    begin = float(data.t[0])
    there = start(begin, [0.5, 0.4, 0.0, 0.0])
    later = start(begin + 0.01, [0.52, 0.37, 2.0, -3.0])
    assert later == pytest.approx(there, abs=1e-12)


def test_the_model_before_where_there_is_no_other():
    diagnosis = diagnosis_of()
    found = tp.predict(diagnosis, omega=13.0, duration=0.2, rate=100.0)
    before = tp.predict(diagnosis, omega=13.0, duration=0.2, rate=100.0, model="before")
    np.testing.assert_array_equal(found.phi1, before.phi1)
    with pytest.raises(InputError, match="only a model 'before'"):
        tp.predict(diagnosis, omega=13.0, duration=0.2, rate=100.0, model="after")


def test_a_drive_that_was_never_seen():
    with pytest.raises(InputError, match="knows no commanded drive"):
        tp.predict(diagnosis_of(A=0.0), omega=13.0, duration=0.2, rate=100.0)


def test_the_pendulum_of_a_diagnosis():
    """Its angles are those of the bodies, without the zeros of the sensors."""
    found = tp.Diagnosis.read(diagnosis_of())
    run = found.predict(omega=13.0, duration=0.2, rate=100.0)
    motion = tp.simulate(found.pendulum(omega=13.0), run.t)
    np.testing.assert_allclose(motion.phi1 + ZERO1, run.phi1, atol=1e-9)
    np.testing.assert_allclose(motion.phi2 + ZERO2, run.phi2, atol=1e-9)
    at_rest = tp.simulate(found.pendulum(), run.t)
    assert np.abs(at_rest.phi1).max() < 1e-9
    with pytest.raises(InputError, match="duration"):
        found.pendulum(duration=0.0)


def test_drifts_run_on_the_clock_of_the_fit(folder):
    """That of the campaign, say; not on one of their own."""
    campaign = synthetic_campaign(1e-5)
    runs = [dataclasses.replace(r, start=100.0 * i) for i, r in enumerate(campaign.recordings)]
    setting = prepare_campaign(dataclasses.replace(campaign, recordings=tuple(runs)))
    values = synthetic_values(setting).replace({"zero1": ZERO1, "zero2": ZERO2})
    values = values.replace({"spring_relaxation.a": 0.2})
    labels = [r.label for r in setting.recordings]
    record = fit_record(values, ("spring_relaxation",), labels)
    wanted = [[0.5 * 203.0 - 100.0 * i, 1.0 / 203.0] for i in range(3)]
    np.testing.assert_allclose(list(record["drift"].values()), wanted)
    diagnosis = {"fits": {"before": record, "after": None}}
    given = dict(recording=folder / "run-17.csv", duration=1.0, rate=250.0)
    late = tp.predict(diagnosis, **given)
    del record["drift"]
    assert np.abs(late.phi1 - tp.predict(diagnosis, **given).phi1).max() > 1e-2


def test_a_result_keeps_every_number_of_a_fit():
    """So that whoever reads diagnosis.json predicts with the model that was judged."""
    setting = prepare_campaign(synthetic_campaign(1e-5))
    values = synthetic_values(setting).replace({"preload": 0.3, "zero1": ZERO1})
    values = values.replace({"contact_repeatability.a": [0.2, 0.0, 0.1]})
    labels = [r.label for r in setting.recordings]
    ids = ("contact_repeatability", "spring_hardening")
    record = fit_record(values, ids, labels, elsewhere=values)
    kept = ModelFit.read(json.loads(json.dumps(record))).to_dict()
    assert json.loads(json.dumps(kept)) == json.loads(json.dumps(record))
    again = pendulum(kept, drive_for(kept, omega=13.0))
    assert float(again.spring.preload) == 0.3
    (own,) = (a for a in again.terms if a.effect.id == "contact_repeatability")
    assert float(own.values["a"]) == 0.2  # expected elsewhere; the mean is .1


def test_readings_of_a_drive_are_freed_of_noise_as_in_the_diagnosis(tmp_path):
    t = np.arange(1501) / 250.0
    drive = 1.5 * np.sin(13.0 * t + 0.3)
    noise = 0.015 * np.random.default_rng(1).standard_normal(t.size)

    def predicted(name, reading):
        text = ['name = "m"', "[rig]", "B1 = 1.2e-3", "[[recording]]", f'file = "{name}.csv"']
        text += ["forced = true", 'drive = "measured"', ""]
        (tmp_path / name).mkdir()
        write_csv(
            tmp_path / name / f"{name}.csv",
            t,
            0.1 * np.sin(9.0 * t),
            0.02 * np.cos(9.0 * t),
            reading,
        )
        (tmp_path / name / "campaign.toml").write_text("\n".join(text), encoding="utf-8")
        return tp.predict(diagnosis_of(gain=1.0), recording=tmp_path / name / f"{name}.csv").phi1

    clean, noisy = predicted("clean", drive), predicted("noisy", drive + noise)
    assert np.abs(clean).max() > 0.2
    assert np.abs(noisy - clean).max() < 5e-3  # .03 by the readings as they are


# Every effect of the catalogue --------------------------------------------------------------------


@pytest.fixture(scope="module")
def every():
    """ids -> a diagnosis by the true numbers whose causes they are, each of its typical size."""
    setting = prepare_campaign(synthetic_campaign(1e-5))
    values = synthetic_values(setting)
    for effect in catalogue().values():
        numbers = {effect.qualified(a.name): a.typical for a in effect.amplitudes}
        numbers |= {effect.qualified(s.name): s.grid[len(s.grid) // 2] for s in effect.shapes}
        values = values.replace(numbers)
    labels = [r.label for r in setting.recordings]
    before = fit_record(values, (), labels)

    def diagnosis(*ids: str, only: str | None = None) -> dict:
        """Of these causes; with `only`, all others have no strength."""
        record = json.loads(json.dumps(fit_record(values, ids, labels)))  # as read from a file
        for id in (id for id in ids if only not in (None, id)):
            record["effects"][id] |= {a.name: 0.0 for a in catalogue()[id].amplitudes}
        return {"fits": {"before": before, "after": record}}

    return diagnosis


STATEFUL = sorted(id for id, effect in catalogue().items() if effect.n_states)
STATELESS = sorted(set(catalogue()) - set(STATEFUL))
SHORT = dict(duration=0.4, rate=100.0)


@pytest.fixture(scope="module")
def check(every):
    """Sees that both runs are there to the end, and are not the one without causes."""
    first = every()
    without = tp.predict(first, omega=13.0, **SHORT, model="before")

    def check(*ids: str, only: str | None = None) -> None:
        diagnosis = every(*ids, only=only)
        unrecorded = all(catalogue()[id].reads_later for id in (ids if only is None else [only]))
        for run in (dict(omega=13.0), dict(phi1=1.0)):
            found = tp.predict(diagnosis, **run, **SHORT)
            y = np.stack([found.phi1, found.phi2])
            assert y.shape == (2, 41)
            assert np.isfinite(y).all()
            # of a drive that stands nothing is heard in a decay, and one that is not recorded
            # is not recorded late
            if "omega" in run and not unrecorded:
                assert np.abs(y - np.stack([without.phi1, without.phi2])).max() > 1e-8

    return check


@pytest.mark.parametrize("id", STATEFUL)
def test_causes_with_states_of_their_own(id, check):
    check(id)


@pytest.mark.slow
@pytest.mark.parametrize("id", STATELESS)
def test_causes_without(id, check):
    """Beside all others, which have no strength: one program serves for all."""
    check(*STATELESS, only=id)


@pytest.mark.slow
def test_without_strength_causes_change_nothing(every):
    plain = tp.predict(every(), omega=13.0, **SHORT, model="before")
    found = tp.predict(every(*STATELESS, only=""), omega=13.0, **SHORT)
    np.testing.assert_allclose(found.phi1, plain.phi1, atol=1e-9)
    np.testing.assert_allclose(found.phi2, plain.phi2, atol=1e-9)


@pytest.mark.parametrize("id", ["drive_harmonics", "bearing_position", "sensor2_eccentricity"])
def test_a_cause_alone(id, check):
    check(id)


@pytest.mark.slow
@pytest.mark.parametrize(
    "ids",
    [
        ("contact_presliding", "base_compliance"),
        ("base_compliance", "sensor2_nonlinearity", "bearing_presliding"),
        ("column_cable", "contact_stribeck"),
        ("channel_delay", "spring_hysteresis"),
        ("clock_skew", "contact_presliding"),
    ],
    ids="+".join,
)
def test_causes_together(ids, check):
    check(*ids)


def test_a_recording_with_a_cause_that_remembers(every, folder):
    run = tp.predict(
        every("contact_presliding"), recording=folder / "decay.csv", duration=0.5, rate=250.0
    )
    assert run.phi1.shape == (126,)
    assert np.isfinite([run.phi1, run.phi2]).all()


def test_memory_begins_at_rest(every):
    """As the diagnosis' own free runs have it, and the readings are those of the whole motion."""
    diagnosis = every("contact_presliding", "sensor_crosstalk")
    record = diagnosis["fits"]["after"]
    found = tp.predict(diagnosis, omega=13.0, **SHORT)
    t = np.arange(41) / 100.0
    model = pendulum(record, drive_for(record, omega=13.0))
    motion = tp.simulate(model, t, np.zeros(5))
    zero2 = np.mean(list(record["nuisances"]["zero2"].values()))
    share = record["effects"]["sensor_crosstalk"]["a"]
    wanted = motion.phi2 + zero2 + share * motion.phi1
    np.testing.assert_allclose(found.phi2, wanted, atol=1e-9)


def test_a_model_that_cannot_be_integrated_is_told(every):
    diagnosis = every("contact_stribeck")
    diagnosis["fits"]["after"]["effects"]["contact_stribeck"]["vs"] = 0.0
    with pytest.raises(InputError, match="cannot be integrated"):
        tp.predict(diagnosis, omega=13.0, **SHORT)
