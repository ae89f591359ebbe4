"""Every figure is drawn from a small analysis, and from one that lacks something."""

import copy

import numpy as np
import pytest

from tp_jax.report.sensitivity import write_figures
from tp_jax.report.sensitivity.files import FIGURES
from tp_jax.results.sensitivity import SensitivityRecord

NAMES = ["k", "Ts1", "Ts2", "T0"]
T = np.linspace(0.0, 1.0, 6)


def through_time(scale):
    return {n: (scale * s * T).tolist() for n, s in zip(NAMES, (1.0, 0.3, 0.0, 1e-4), strict=True)}


def whole(scale):
    return {n: scale * s for n, s in zip(NAMES, (1.0, 0.3, 0.0, 1e-4), strict=True)}


def entry(kind):
    out = {"recording": "run-01.csv", "t": T.tolist(), "runs": 64}
    if kind == "local":
        out |= {"rms": {}, "reliable": {}, "growth": 1.0}
    for c in ("phi1", "phi2"):
        if kind == "local":
            out[c] = through_time(0.1)
        elif kind == "sobol":
            parts = {"variance": (T**2).tolist(), "S1": through_time(0.5), "ST": through_time(0.6)}
            errors = {"S1_conf": whole(0.1), "ST_conf": whole(0.1)}
            out[c] = {"S1": whole(0.5), "ST": whole(0.6), **errors, "through_time": parts}
        else:
            parts = {"mu_star": through_time(0.1), "sigma": through_time(0.05)}
            sizes = {"mu_star": whole(0.1), "mu_star_conf": whole(0.01), "sigma": whole(0.05)}
            out[c] = {**sizes, "through_time": parts}
    return out


@pytest.fixture
def analysis():
    both = {"phi1": whole(0.5), "phi2": whole(0.6)}
    unseen = {"kind": "structural", "sd_log": None, "removed_by": None, "text": "Ts2 alone"}
    over = {"ranges": {}, "unit": "rad"}
    return {
        "campaign": "made",
        "model": "newton",
        "identifiable": {},
        "parameters": {},
        "structural": {
            "parameters": NAMES,
            "recordings": ["run-01.csv"],
            "singular_values": [[9.0, 3.0, 1e-3, 0.0]] * 2,
            "ranks": [3, 3],
            "rank": 3,
            "of": 4,
            "points": 2,
            "gap": 1e9,
            "weakest": [],
        },
        "null_directions": [
            {**unseen, "parameters": {"Ts2": 1.0}},
            {**unseen, "parameters": {"T0": 1.0, "Ts1": -0.2}, "kind": "practical"},
        ],
        "correlation": {"parameters": ["k", "Ts1"], "matrix": [[1.0, -0.8], [-0.8, 1.0]]},
        "fit": {
            "chi2_dof": 1.0,
            "converged": True,
            "message": "",
            "noise_floor": {"phi1": 1e-3, "phi2": 1e-3},
        },
        "local": {"unit": "rad", "scale": {}, "rms": {}, "recordings": [entry("local")]},
        "sobol": {
            **over,
            "samples": 16,
            "recordings": [entry("sobol")],
            "S1": both,
            "ST": both,
        },
        "morris": {**over, "trajectories": 4, "mu_star": {}, "recordings": [entry("morris")]},
        "warnings": [],
        "provenance": {
            "version": "0",
            "seed": 0,
            "data_sha256": {},
            "eps": 1e7,
            "horizon_s": 1.0,
            "spread": 2.0,
            "wall_s": 1.0,
        },
        "profile": {
            "T0": {
                "value": 2.0,
                "identifiable": False,
                "inflation": 1.0,
                "values": [1.0, 2.0, 3.0],
                "drops": [4.0, 0.0, 2.0],
                "level": 4.0,
                "ci95": [1.0, None],
                "unit": "s/rad",
            },
        },
    }


def test_all_are_written(analysis, tmp_path):
    written = write_figures(SensitivityRecord.read(analysis), tmp_path / "new")
    assert [p.stem for p in written] == list(FIGURES)
    assert sorted(p.name for p in (tmp_path / "new").iterdir()) == sorted(p.name for p in written)
    for path in written:
        assert path.read_bytes().startswith(b"\x89PNG")
        assert path.stat().st_size > 5000


def test_what_is_not_there_is_not_drawn_and_an_old_one_goes(analysis, tmp_path):
    (tmp_path / "profiles.png").write_bytes(b"old")
    written = write_figures({**analysis, "profile": {}}, tmp_path)
    assert "profiles" not in [p.stem for p in written]
    assert not (tmp_path / "profiles.png").exists()


def test_one_channel(analysis):
    only = copy.deepcopy(analysis)
    for part in ("local", "sobol", "morris"):
        for r in only[part]["recordings"]:
            del r["phi2"]
    for key in ("S1", "ST"):
        only["sobol"][key].pop("phi2", None)
    for name, draw in FIGURES.items():
        assert draw(SensitivityRecord.read(only)) is not None, name


def test_that_ts2_does_nothing_is_said(analysis):
    found = SensitivityRecord.read(analysis)
    texts = [t.get_text() for a in FIGURES["sobol"](found).axes for t in a.texts]
    assert any("no effect" in t for t in texts)
    texts = [t.get_text() for a in FIGURES["morris"](found).axes for t in a.texts]
    assert "Ts2: no effect" in texts
