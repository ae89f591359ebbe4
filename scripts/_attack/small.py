"""A diagnosis.json by hand, as small as one can be that predicts."""


def fit(**effects) -> dict:
    """A fit of the bench with these effects."""
    return {
        "kind": "double",
        "parameters": {
            "B1": 1.2e-3,
            "B2": 5.0e-4,
            "k": 0.45,
            "A": 0.18,
            "c1": 2.2e-3,
            "M1": 5.0e-3,
            "Tv": 2.5e-4,
            "Ts1": 1.25e-2,
            "Ts2": 0.0,
            "Tst": 2.5e-3,
            "T0": 4.0,
        },
        "reaction": 1.0,
        "eps": 5.0e4,
        "nuisances": {
            "phase": 0.0,
            "gain": 0.0,
            "level": 0.0,
            "zero1": 0.01,
            "zero2": {"decay.csv": 0.0, "run-13.csv": 0.02},
        },
        "drift": {"decay.csv": [5.0, 0.1], "run-13.csv": [5.0, 0.1]},
        "effects": effects,
    }


def diagnosis() -> dict:
    """One cause, and something in every part that is checked."""
    size = {"value": 0.5, "unit": "1", "ci95": [0.4, 0.6]}
    return {
        "schema": "tp-jax/diagnosis/1",
        "campaign": "bench",
        "model": "newton",
        "verdict": "explained",
        "noise_floor": {"phi1": 1e-3, "phi2": None},
        "gap": {
            "before": {"windowed": 4e-3, "free_run": None},
            "after": {"windowed": 1e-3, "free_run": 2e-3},
            "shrink": 0.98,
            "shrink_ci95": [0.96, 0.99],
            "held_out": ["run-13.csv"],
        },
        "where": [{"location": "contact", "channel": "contact", "share": 1.0, "when": None}],
        "causes": [
            {
                "effect": "contact_stribeck",
                "location": "contact",
                "channel": "contact",
                "probability": 0.97,
                "shrink": 0.98,
                "parameters": {"a": dict(size), "vs": dict(size)},
            }
        ],
        "candidates": [
            {"effect": "contact_stribeck", "applicable": True, "probability": 0.97},
            {"effect": "drive_steps", "applicable": False, "probability": None, "note": "No."},
        ],
        "confused_with": [["contact_stribeck", "contact_presliding"]],
        "minimum_detectable": {"contact_stribeck": {"value": None, "unit": "1"}},
        "absorbed": {"k": {"shift": 0.01, "in_standard_errors": None, "unit": "N m/rad"}},
        "fits": {"before": fit(), "after": fit(contact_stribeck={"a": 0.5, "vs": 1.0})},
        "parameters": {"k": {**size, "identifiable": True}},
        "next_experiment": {"omega": 8.0, "forced": True, "separates": ["a", "b"]},
        "recordings": [
            {
                "label": "run-13.csv",
                "sha256": "",
                "held_out": True,
                "start": {"before": [0.0, 0.0, 0.0, 0.0], "after": None},
            }
        ],
        "curves": [],
        "residuals": [],
        "notes": ["a note"],
        "provenance": {"version": "0.1.0", "seed": 0},
    }
