"""Every figure is drawn from a small analysis, and from one that lacks something."""

import copy

import numpy as np
import pytest

from tp_jax.report.sensitivity import write_figures
from tp_jax.report.sensitivity.files import FIGURES

NAMES = ["k", "Ts1", "Ts2", "T0"]
T = np.linspace(0.0, 1.0, 6)


def through_time(scale):
    return {n: (scale * s * T).tolist() for n, s in zip(NAMES, (1.0, 0.3, 0.0, 1e-4), strict=True)}


def whole(scale):
    return {n: scale * s for n, s in zip(NAMES, (1.0, 0.3, 0.0, 1e-4), strict=True)}


def entry(kind):
    out = {"recording": "run-01.csv", "t": T.tolist()}
    for c in ("phi1", "phi2"):
        if kind == "local":
            out[c] = through_time(0.1)
        elif kind == "sobol":
            parts = {"variance": (T**2).tolist(), "S1": through_time(0.5), "ST": through_time(0.6)}
            out[c] = {"S1": whole(0.5), "ST": whole(0.6), "through_time": parts}
        else:
            out[c] = {"mu_star": whole(0.1), "sigma": whole(0.05)}
    return out


@pytest.fixture
def analysis():
    both = {"phi1": whole(0.5), "phi2": whole(0.6)}
    return {
        "structural": {
            "parameters": NAMES,
            "singular_values": [[9.0, 3.0, 1e-3, 0.0]] * 2,
            "rank": 3,
            "points": 2,
        },
        "null_directions": [
            {"parameters": {"Ts2": 1.0}, "kind": "structural", "removed_by": None},
            {"parameters": {"T0": 1.0, "Ts1": -0.2}, "kind": "practical", "removed_by": None},
        ],
        "correlation": {"parameters": ["k", "Ts1"], "matrix": [[1.0, -0.8], [-0.8, 1.0]]},
        "fit": {"noise_floor": {"phi1": 1e-3, "phi2": 1e-3}},
        "local": {"recordings": [entry("local")]},
        "sobol": {"recordings": [entry("sobol")], "S1": both, "ST": both},
        "morris": {"recordings": [entry("morris")]},
        "profile": {
            "T0": {
                "values": [1.0, 2.0, 3.0],
                "drops": [4.0, 0.0, 2.0],
                "level": 4.0,
                "ci95": [1.0, None],
                "unit": "s/rad",
            },
        },
    }


def test_all_are_written(analysis, tmp_path):
    written = write_figures(analysis, tmp_path / "new")
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
        assert draw(only) is not None, name


def test_that_ts2_does_nothing_is_said(analysis):
    texts = [t.get_text() for a in FIGURES["sobol"](analysis).axes for t in a.texts]
    assert any("no effect" in t for t in texts)
    texts = [t.get_text() for a in FIGURES["morris"](analysis).axes for t in a.texts]
    assert "Ts2: no effect" in texts
