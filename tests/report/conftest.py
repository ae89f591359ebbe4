"""Made-up diagnoses of every kind."""

import copy

import numpy as np
import pytest

EFFECTS = (
    "contact_stribeck",
    "contact_presliding",
    "contact_wear",
    "contact_position",
    "contact_asymmetry",
    "spring_asymmetry",
    "bearing_stribeck",
    "drive_harmonics",
    "sensor2_nonlinearity",
    "channel_delay",
    "column_tilt",
    "clock_skew",
)


def _curve(t, amplitude, omega, late, shift, noise, generator):
    """An oscillation, a model that falls behind it, and one that does not."""
    swing = amplitude * (1.0 - 0.4 * np.exp(-t / 3.0)) * np.sin(omega * t)
    before = amplitude * (1.0 - 0.5 * np.exp(-t / 3.0)) * np.sin(omega * t - late * t) + shift * t
    measured = swing + noise * generator.standard_normal(t.size)
    return {"measured": measured.tolist(), "before": before.tolist(), "after": swing.tolist()}


def explained() -> dict:
    """A double pendulum whose contact has a Stribeck effect."""
    g = np.random.default_rng(0)
    t = np.linspace(0.0, 12.0, 600)
    stick = np.abs(np.sin(2.1 * t)) ** 6
    noise = {c: g.standard_normal((2, t.size)) for c in ("phi1", "phi2")}
    predicted = [0.97, 0.91, 0.42, 0.31, 0.12, 0.08, 0.07, 0.05, 0.03, 0.02, 0.01, 0.002]
    realised = [0.98, 0.71, 0.36, 0.29, -0.4, 0.08, *[None] * 6]
    probability = [0.971, 0.02, 0.004, *[0.001] * 9]
    return {
        "schema": "tp-jax/diagnosis/1",
        "campaign": "case-03",
        "model": "newton",
        "verdict": "explained",
        "noise_floor": {"phi1": 0.00101, "phi2": 0.00099},
        "gap": {
            "before": {"windowed": 0.0041, "free_run": 0.052},
            "after": {"windowed": 0.0011, "free_run": 0.0014},
            "shrink": 0.98,
            "shrink_ci95": [0.96, 0.99],
            "held_out": ["run-17.csv"],
            "horizon_s": 0.5,
            "removable_significant": True,
            "structure_p": 2e-9,
        },
        "where": [
            {
                "location": "contact",
                "channel": "contact",
                "share": 0.93,
                "when": "sliding below 1 rad/s",
            },
            {"location": "bearing", "channel": "column", "share": 0.05, "when": "around reversals"},
            {"location": "spring", "channel": "column", "share": 0.02, "when": None},
        ],
        "causes": [
            {
                "effect": "contact_stribeck",
                "location": "contact",
                "probability": 0.97,
                "shrink": 0.98,
                "parameters": {
                    "strength": {"value": 0.58, "unit": "1", "ci95": [0.55, 0.61]},
                    "vs": {"value": 0.3, "unit": "rad/s", "ci95": None},
                },
                "remedy": "clean the contact's surfaces, or use a pad of PTFE",
                "by_hand": "pull the rider slowly with a spring balance, and compare "
                "the two forces",
                "agreement": {"improved": 5, "of": 6, "worse": ["decay.csv"], "drops": {}},
            }
        ],
        "candidates": [
            {
                "effect": e,
                "location": e.split("_")[0],
                "predicted_shrink": p,
                "realised_shrink": r,
                "probability": q,
                "note": None,
            }
            for e, p, r, q in zip(EFFECTS, predicted, realised, probability, strict=True)
        ]
        + [
            {
                "effect": "reaction_factor",
                "location": "model",
                "applicable": False,
                "predicted_shrink": None,
                "realised_shrink": None,
                "probability": None,
            }
        ],
        "confused_with": [["contact_stribeck", "contact_presliding"]],
        "minimum_detectable": {
            "spring_asymmetry": {"value": 0.004, "unit": "1"},
            "spring_hardening": {"value": 0.0123, "unit": "1/rad^2"},
            "bearing_drag": {"value": 1.2e-6, "unit": "N m s^2/rad^2"},
            "drive_steps": {"value": None, "unit": "1"},
        },
        "absorbed": {
            "Ts1": {"shift": -0.0012, "in_standard_errors": -31.4},
            "k": {"shift": 0.0004, "in_standard_errors": 1.2},
        },
        "fits": {"before": {}, "after": {}},
        "parameters": {
            "k": {
                "value": 0.4502,
                "unit": "N m/rad",
                "ci95": [0.4498, 0.4506],
                "identifiable": True,
            },
            "B2": {
                "value": 5.01e-4,
                "unit": "kg m^2",
                "ci95": [4.98e-4, 5.04e-4],
                "identifiable": True,
            },
            "Ts1": {"value": 0.0125, "unit": "N m", "ci95": [0.0121, 0.0129], "identifiable": True},
            "c1": {
                "value": 2.2e-5,
                "unit": "N m s/rad",
                "ci95": [2.1e-5, 2.3e-5],
                "identifiable": True,
            },
            "T0": {"value": 4.0, "unit": "s/rad", "ci95": None, "identifiable": False},
        },
        "next_experiment": {
            "omega": 8.0,
            "forced": True,
            "expected_sigma": 6.1,
            "separates": ["contact_stribeck", "contact_presliding"],
        },
        "provenance": {
            "version": "0.1.0",
            "seed": 0,
            "wall_s": 12.34,
            "data_sha256": {"run-06.csv": "a1" * 32, "run-17.csv": "b2" * 32},
        },
        "curves": [
            {
                "recording": "run-17.csv",
                "t": t.tolist(),
                "phi1": _curve(t, 0.31, 6.3, 0.02, 0.001, 0.001, g),
                "phi2": _curve(t, 0.9, 6.3, 0.05, -0.02, 0.001, g),
            }
        ],
        "residuals": [
            {
                "recording": "run-17.csv",
                "t": t.tolist(),
                "phi1": {
                    "before": (2 * stick + noise["phi1"][0]).tolist(),
                    "after": noise["phi1"][1].tolist(),
                },
                "phi2": {
                    "before": (-9 * stick * np.sin(6.3 * t) + noise["phi2"][0]).tolist(),
                    "after": noise["phi2"][1].tolist(),
                },
            }
        ],
        "recordings": [
            {
                "label": "decay.csv",
                "held_out": False,
                "forced": False,
                "omega": None,
                "duration": 10.0,
                "samples": 2501,
            },
            {
                "label": "run-06.csv",
                "held_out": False,
                "forced": True,
                "omega": 6.0,
                "duration": 10.0,
                "samples": 2501,
            },
            {
                "label": "run-17.csv",
                "held_out": True,
                "forced": True,
                "omega": None,
                "duration": 12.0,
                "samples": 3001,
            },
        ],
        "notes": ["Ts1, Tst and T0 are nearly confounded in this data."],
    }


def no_gap() -> dict:
    """The model is complete as far as the data can tell."""
    d = explained()
    d["verdict"] = "no_gap"
    d["gap"] |= {
        "before": {"windowed": 0.00101, "free_run": 0.00112},
        "after": None,
        "shrink": None,
        "shrink_ci95": None,
        "removable_significant": False,
        "structure_p": 0.4123,
    }
    d["where"], d["causes"], d["confused_with"], d["absorbed"] = [], [], [], {}
    for row in d["candidates"]:
        row.update(realised_shrink=None, probability=None, predicted_shrink=None)
    for entry in d["curves"]:
        for c in ("phi1", "phi2"):
            entry[c]["before"], entry[c]["after"] = entry[c]["after"], None
    for entry in d["residuals"]:
        for c in ("phi1", "phi2"):
            entry[c]["before"], entry[c]["after"] = entry[c]["after"], None
    d["next_experiment"] = {
        "forced": False,
        "phi1": 0.8,
        "separates": ["column_tilt"],
        "expected_sigma": 3.0,
    }
    return d


def unknown() -> dict:
    """A gap in the contact that nothing in the catalogue explains."""
    d = explained()
    d["verdict"] = "unknown"
    d["gap"] |= {
        "after": {"windowed": 0.0041, "free_run": 0.052},
        "shrink": 0.0,
        "shrink_ci95": [-0.02, 0.01],
    }
    d["where"][0]["share"], d["where"][1]["share"], d["where"][2]["share"] = 0.71, 0.2, 0.09
    d["causes"] = []
    for row in d["candidates"]:
        for key in ("predicted_shrink", "realised_shrink", "probability"):
            row[key] = None if row[key] is None else 0.3 * row[key]
    for entry in (*d["curves"], *d["residuals"]):
        for c in ("phi1", "phi2"):
            entry[c]["after"] = None
    return d


def partly() -> dict:
    """Two causes that hold a part of it."""
    d = explained()
    d["verdict"] = "unknown"
    d["gap"] |= {
        "after": {"windowed": 0.003, "free_run": 0.03},
        "shrink": 0.49,
        "shrink_ci95": [0.41, 0.56],
    }
    second = copy.deepcopy(d["causes"][0]) | {"effect": "spring_asymmetry", "location": "spring"}
    d["causes"].append(second)
    return d


def single() -> dict:
    """A column alone: no phi2 anywhere."""
    d = explained()
    d["noise_floor"] = {"phi1": 0.00101}
    d["causes"][0] |= {"effect": "spring_asymmetry", "location": "spring"}
    d["where"] = [{"location": "spring", "channel": "column", "share": 1.0, "when": "throughout"}]
    del d["curves"][0]["phi2"]
    d["residuals"][0]["phi2"] = None
    return d


def bare() -> dict:
    """Nothing but a verdict."""
    return {"verdict": "explained"}


def nulls() -> dict:
    """Every entry is there and null."""
    return dict.fromkeys(explained())


def hollow() -> dict:
    """Tables and lists whose entries are null."""
    d = explained()
    return {
        key: dict.fromkeys(value)
        if isinstance(value, dict)
        else [dict.fromkeys(value[0])]
        if isinstance(value, list) and isinstance(value[0], dict)
        else value
        for key, value in d.items()
    }


def fit_with(B1: float) -> dict:
    """A fit as diagnosis.json keeps it, of a rig of that inertia [kg m^2]."""
    return {
        "kind": "single",
        "reaction": 1.0,
        "eps": 1e7,
        "nuisances": {"phase": 0, "gain": 0, "level": 0, "zero1": 0, "zero2": {"a.csv": 0}},
        "drift": {},
        "effects": {},
        "parameters": {"B1": B1, "k": 0.45, "A": 0.17, "c1": 2e-3, "M1": 4e-3},
    }


KINDS = {
    "explained": explained,
    "no_gap": no_gap,
    "unknown": unknown,
    "partly": partly,
    "single": single,
    "bare": bare,
    "nulls": nulls,
    "hollow": hollow,
    "empty": dict,
}


@pytest.fixture(params=list(KINDS))
def diagnosis(request) -> dict:
    """A diagnosis of each kind in turn."""
    return KINDS[request.param]()


@pytest.fixture(scope="module", params=list(KINDS))
def any_diagnosis(request) -> dict:
    """As `diagnosis`, for what is made of it once and only looked at."""
    return KINDS[request.param]()


@pytest.fixture
def made():
    """Makes a diagnosis of a kind."""
    return lambda kind: KINDS[kind]()
