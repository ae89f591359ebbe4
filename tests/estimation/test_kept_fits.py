"""Fits that are kept in a file are looked up there, and are the same to the last bit."""

import dataclasses
import json

import numpy as np
import pytest

from tests.rigs import synthetic_campaign
from tp_jax.errors import InputError
from tp_jax.estimation import kept_fits, variable_projection
from tp_jax.estimation.checkpoint import digest_of
from tp_jax.estimation.kept_fits import fits_checkpoint, keeping
from tp_jax.estimation.prepared_campaign import prepare_campaign
from tp_jax.estimation.start import initial_values


@pytest.fixture(scope="module")
def setting():
    return prepare_campaign(synthetic_campaign(), effects=())


def checkpoint_of(setting, path, resume=False, seed=0):
    return fits_checkpoint(path, resume, setting.campaign, {"seed": seed})


def fitted(setting, fitter, steps=3):
    return fitter(
        setting.problem(setting.horizons[0]),
        initial_values(setting),
        setting.unknowns(),
        bounds=setting.bounds,
        priors=setting.priors(),
        max_iterations=steps,
    )


def same(one, other):
    for name in ("states", "at_bound"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    np.testing.assert_array_equal(one.values.table, other.values.table)
    for part in ("linearisation", "eliminated"):
        mine, others = getattr(one, part), getattr(other, part)
        for field in dataclasses.fields(mine):
            np.testing.assert_array_equal(getattr(mine, field.name), getattr(others, field.name))
    for name in ("cost", "converged", "evaluations", "message", "priors", "unknowns"):
        assert getattr(one, name) == getattr(other, name)


def test_a_kept_fit_is_the_same_to_the_last_bit(setting, tmp_path):
    path = tmp_path / "new" / "fits.json"
    alone = fitted(setting, variable_projection.fit)
    with keeping(checkpoint_of(setting, path)):
        first = fitted(setting, variable_projection.fit)
    resumed = checkpoint_of(setting, path, resume=True)
    assert len(resumed.done) == 1
    with keeping(resumed):
        kept = kept_fits._current.get()
        again = fitted(setting, variable_projection.fit)
        assert kept.taken == 1
        fitted(setting, variable_projection.fit, steps=2)  # another one
        assert kept.taken == 1
    same(first, alone)
    same(again, alone)
    assert kept_fits._current.get() is None
    assert len(checkpoint_of(setting, path, resume=True).done) == 2


def test_without_a_file_fits_are_kept_in_memory(setting):
    with keeping(None):
        first = fitted(setting, variable_projection.fit)
        again = fitted(setting, variable_projection.fit)
        assert kept_fits._current.get().taken == 1
    same(again, first)
    assert kept_fits._current.get() is None


def test_a_drive_that_was_put_right_is_another_fit(setting):
    problem = setting.problem(setting.horizons[0])

    def digest(drive):
        prepared = (dataclasses.replace(problem.prepared[0], pieces=drive), *problem.prepared[1:])
        read = dataclasses.replace(problem, prepared=prepared)
        return kept_fits._digest(fitted, read, initial_values(setting), (), None, {})

    drive = np.zeros((problem.prepared[0].t.size - 1, 4))
    assert digest(drive) == digest(drive.copy()) != digest(drive + 1e-6)


def test_a_fit_that_does_not_end_where_it_did_is_done_anew(setting, tmp_path):
    path = tmp_path / "fits.json"
    with keeping(checkpoint_of(setting, path)):
        first = fitted(setting, variable_projection.fit)
    content = json.loads(path.read_text())
    (record,) = content["done"].values()
    record["ends_at"] = "0" * 64
    content["done_sha256"] = digest_of(content["done"])
    path.write_text(json.dumps(content))
    with keeping(checkpoint_of(setting, path, resume=True)):
        same(fitted(setting, variable_projection.fit), first)
        assert kept_fits._current.get().taken == 0


def test_what_is_done_is_written_however_it_ends(setting, tmp_path):
    path = tmp_path / "fits.json"

    def broken_off():
        with keeping(checkpoint_of(setting, path)):
            assert path.is_file()  # from the first moment
            fitted(setting, variable_projection.fit)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        broken_off()
    assert len(checkpoint_of(setting, path, resume=True).done) == 1


def test_writes_are_not_too_frequent(setting, tmp_path):
    now = [0.0]
    kept = kept_fits.KeptFits(checkpoint_of(setting, tmp_path / "fits.json"), lambda: now[0])
    kept.write()
    kept._new["a"] = {}
    kept.write(at_once=False)
    assert kept.checkpoint.done == {}
    now[0] = kept_fits.WRITE_EVERY
    kept.write(at_once=False)
    assert kept.checkpoint.done == {"a": {}}


@pytest.mark.parametrize("changed", ["seed", "recordings", "rig", "source"])
def test_another_diagnosis_is_refused(setting, tmp_path, monkeypatch, changed):
    path = tmp_path / "fits.json"
    with keeping(checkpoint_of(setting, path)):
        pass
    seed = 1 if changed == "seed" else 0
    campaign = setting.campaign
    if changed == "recordings":
        first, *others = campaign.recordings
        first = dataclasses.replace(first, phi1=first.phi1 + 1e-9)
        campaign = dataclasses.replace(campaign, recordings=(first, *others))
    if changed == "rig":
        campaign = dataclasses.replace(campaign, B1=2.0 * campaign.B1)
    if changed == "source":
        monkeypatch.setattr(kept_fits, "source_digest", lambda: "changed")
    with pytest.raises(InputError, match=rf"another diagnosis \(it differs in {changed}\)"):
        fits_checkpoint(path, True, campaign, {"seed": seed})


def test_nothing_to_resume(setting, tmp_path):
    with pytest.raises(InputError, match="nothing to resume"):
        checkpoint_of(setting, tmp_path / "fits.json", resume=True)
    with pytest.raises(InputError, match="must be named"):
        checkpoint_of(setting, None, resume=True)
    assert checkpoint_of(setting, None) is None
