"""Section 5.1 as printed: what moves, what slips, what (17) can see."""

from typing import Any

import numpy as np

from scripts._paper.objective import ORDER, Objective, motion, of_preset
from tp_jax.identifiability.design import UNKNOWNS, Design, sine_design
from tp_jax.identifiability.log_derivatives import log_derivatives
from tp_jax.identifiability.rank import rank
from tp_jax.model import presets
from tp_jax.model.parameters import PAPER_EPS
from tp_jax.model.pendulum import NEWTON_REACTION, PRINTED_REACTION
from tp_jax.simulation.solve import simulate

OMEGA = 0.5  # rad/s, Section 5.1
SLIPPING = 2.1  # rad/s, near resonance: the same rig, and the rider does slip
NOISE = 1e-3  # rad, of a good angle sensor
PART = 0.1  # a parameter's change by which (17) is probed


def recorded(x, omega: float, ts: np.ndarray, noise: float = 0.0, seed: int = 0) -> Objective:
    """A run of the printed model as if it had been measured."""
    m = motion(x, omega, ts)
    white = noise * np.random.default_rng(seed).standard_normal((2, ts.size))
    return Objective(ts, np.asarray(m.phi1) + white[0], np.asarray(m.phi2) + white[1], omega)


def contact(ts: np.ndarray) -> dict[str, Any]:
    """Checks if the rider slips in Section 5.1's run, at the printed smoothing and at a finer one.

    A body that sticks under smoothed friction creeps, ever more slowly the finer the smoothing;
    one that slips does not care.
    """
    values = presets.values("paper-5.1")
    out: dict[str, Any] = {"breakaway": values["Ts1"], "by_eps": []}
    for eps in (PAPER_EPS, 1e2 * PAPER_EPS):
        for omega in (OMEGA, SLIPPING):
            model = presets.double_pendulum(**{**values, "eps": eps, "omega": omega})
            m = simulate(model, ts, tolerance=1e-9)
            y = (m.phi1, m.phi2, m.omega1, m.omega2)
            torque = np.asarray(model.motion(m.t, y).contact)
            out["by_eps"].append(
                {
                    "eps": eps,
                    "omega": omega,
                    "largest_phi2": float(np.abs(m.phi2).max()),
                    "largest_velocity": float(np.abs(m.omega2).max()),
                    "largest_torque": float(np.abs(torque).max()),
                    "samples_at_rest_exactly": int((np.asarray(m.omega2) == 0.0).sum()),
                    "samples": int(ts.size),
                }
            )
    return out


def unseen(ts: np.ndarray) -> dict[str, Any]:
    """Changes of the printed model that no angle shows, as largest differences of motion [rad]."""
    values = {**presets.values("paper-5.1"), "omega": SLIPPING}
    base = simulate(presets.double_pendulum(**values), ts)

    def difference(change: dict[str, float]) -> float:
        other = simulate(presets.double_pendulum(**{**values, **change}), ts)
        angles = ((base.phi1, other.phi1), (base.phi2, other.phi2))
        return max(float(np.abs(np.asarray(a - b)).max()) for a, b in angles)

    of_the_column = ("B1", "k", "c1", "M1")
    torques = (*of_the_column, "B2", "Tv", "Ts1", "Ts2", "Tst")
    halved = {n: 0.5 * values[n] for n in of_the_column} | {"reaction": NEWTON_REACTION}
    return {
        "omega": SLIPPING,
        "largest_phi2": float(np.abs(np.asarray(base.phi2)).max()),
        "newton_with_the_column_halved": difference(halved),
        "newton_with_nothing_changed": difference({"reaction": NEWTON_REACTION}),
        "all_torques_times_7": difference({n: 7.0 * values[n] for n in torques}),
        "Ts2_times_100": difference({"Ts2": 100.0 * values["Ts2"]}),
        "T0_1000_against_Tst_in_Ts1": difference_at_high_T0(values, ts),
    }


def difference_at_high_T0(values: dict[str, float], ts: np.ndarray) -> float:
    """Shows that at the start's T0 of 1000 the Tst term is as good as Ts1's [rad]."""
    steep = {**values, "T0": 1000.0}
    merged = {**values, "Ts1": values["Ts1"] + values["Tst"], "Tst": 0.0}
    a, b = (simulate(presets.double_pendulum(**v), ts) for v in (steep, merged))
    return float(np.abs(np.asarray(a.phi2 - b.phi2)).max())


def seen(ts: np.ndarray) -> dict[str, Any]:
    """Computes what a change of ten per cent of each parameter does to y, in both designs.

    In addition the y from which on a change is more than the noise (four units of chi-square):
    that much better than y itself, of the size of the noise squared, could see it.
    """
    x = of_preset("paper-5.1")
    out: dict[str, Any] = {"part": PART, "detectable": 2.0 * NOISE**2 / ts.size}
    for name, omega in (("printed", OMEGA), ("slipping", SLIPPING)):
        objective = recorded(x, omega, ts)
        changed = {}
        for i, n in enumerate(ORDER):
            other = x.copy()
            other[i] *= 1.0 + PART
            changed[n] = objective(other)
        out[name] = {"omega": omega, "y": changed, "standard_errors": _errors(ts, omega)}
    return out


def _design(ts: np.ndarray, omega: float) -> Design:
    return sine_design(omega, ts, noise=NOISE, eps=PAPER_EPS, reaction=PRINTED_REACTION)


def _errors(ts: np.ndarray, omega: float) -> dict[str, float | None]:
    """Relative standard errors, B1 held and Ts2 left out; None: above a factor of ten."""
    values = dict(zip(ORDER, of_preset("paper-5.1").tolist(), strict=True))
    names = [n for n in ORDER if n not in ("B1", "Ts2")]
    rows = log_derivatives(_design(ts, omega), values, names).weighted(np.full(2, NOISE))
    _, s, v = np.linalg.svd(rows, full_matrices=False)
    variance = ((v.T / np.maximum(s, 1e-12)) ** 2).sum(axis=1)
    sds = np.sqrt(variance).tolist()
    return {n: sd if sd < 10.0 else None for n, sd in zip(names, sds, strict=True)}


def structure(ts: np.ndarray, points: int) -> dict[str, Any]:
    """Rank of the sensitivity matrix of the printed model, the factor in (16a) free as well."""
    values = dict(zip(ORDER, of_preset("paper-5.1").tolist(), strict=True))
    designs = [_design(ts, omega) for omega in (OMEGA, SLIPPING)]
    out = {}
    for key, names in (("eleven", UNKNOWNS), ("with_factor", (*UNKNOWNS, "reaction"))):
        found = rank(designs, {**values, "reaction": PRINTED_REACTION}, names, points=points)
        out[key] = {
            "rank": found.rank,
            "of": len(names),
            "gap": found.gap,
            "null_directions": [d.to_dict() for d in found.directions],
        }
    return out
