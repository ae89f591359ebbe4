"""Predictions from the numbers of a fit."""

import dataclasses

import numpy as np
import pytest

import tp_jax as tp
from tests.rigs import synthetic_campaign, synthetic_values
from tp_jax.errors import InputError
from tp_jax.estimation.assemble import fit_record
from tp_jax.estimation.baseline import prepare_campaign
from tp_jax.recordings import write_csv

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
