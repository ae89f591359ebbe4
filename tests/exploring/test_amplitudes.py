"""One amplitude of the drive for all runs of a campaign."""

import json

import numpy as np
import pytest

from tp_jax.acquisition.run_log import metadata_path
from tp_jax.errors import InputError
from tp_jax.exploring.amplitudes import amplitude_of, announced_amplitude
from tp_jax.recordings import write_csv


def campaign(folder, *runs):
    """Each run: the drive's omega, or None, its amplitude as it was told, as the rig announced."""
    text = ""
    t = np.arange(100) / 100
    for i, (omega, told, announced) in enumerate(runs):
        path = folder / f"run-{i}.csv"
        write_csv(path, t, 0.3 * np.sin(20 * t), 0.1 * np.sin(9 * t))
        of = {"drive": {"amplitude": told}, "device": {"amplitude": announced}}
        metadata_path(path).write_text(json.dumps(of))
        driven = "forced = false" if omega is None else f"omega = {omega}"
        text += f"[[recording]]\nfile = '{path.name}'\n{driven}\n"
    (folder / "campaign.toml").write_text(text)
    return folder


def test_a_new_campaign_is_driven_as_asked(tmp_path):
    assert amplitude_of(tmp_path, 0.5, 0.18) == 0.5
    assert amplitude_of(tmp_path, None, 0.18) is None
    decays = campaign(tmp_path, (None, 0.5, 0.18))
    assert amplitude_of(decays, 0.3, 0.18) == 0.3


def test_another_amplitude_is_refused(tmp_path):
    folder = campaign(tmp_path, (None, None, 0.18), (9.0, None, 0.18))
    with pytest.raises(InputError, match=r"run-1.csv was driven at 0\.18 rad.*--amplitude 0\.18,"):
        amplitude_of(folder, 0.5, 0.18)
    assert amplitude_of(folder, 0.18, None) == 0.18


def test_the_rig_may_have_been_told_another_one_meanwhile(tmp_path):
    folder = campaign(tmp_path, (9.0, 0.1, 0.18))
    assert amplitude_of(folder, None, 0.18) == 0.1
    assert amplitude_of(folder, None, None) == 0.1
    assert amplitude_of(folder, None, 0.1) is None  # as it is
    assert announced_amplitude(folder) == 0.18


def test_nothing_is_known_of_runs_of_another_make(tmp_path):
    folder = campaign(tmp_path, (9.0, None, None))
    metadata_path(folder / "run-0.csv").write_text("no JSON")
    assert amplitude_of(folder, 0.5, 0.18) == 0.5
    assert announced_amplitude(folder) is None
