"""A start from the data: the equations of motion are linear in most parameters.

With angles, velocities and accelerations from local polynomials, the sum of (16a) and (16b) holds
without the contact,

    B1 a1 + B2 (a1 + a2) + k phi1 - k f + c1 v1 + M1 sgn v1 = 0,

and (16b) alone gives the contact's parameters for any T0. Both are solved by bounded linear least
squares, so that nobody needs to guess. `initial_values` adds all that is given or has a default.
"""

from collections.abc import Sequence

import numpy as np
from scipy.optimize import lsq_linear

from tp_jax.estimation.layout import Values
from tp_jax.estimation.prepared_campaign import PreparedCampaign, is_sine
from tp_jax.model.pendulum import NEWTON_REACTION, PRINTED_REACTION
from tp_jax.recordings import Recording
from tp_jax.recordings.gaps import stretches
from tp_jax.recordings.smooth import local_polynomial

ORDER = 3  # of the smoothing polynomials
T0_GRID = np.geomspace(0.5, 50.0, 9)
MOVING, MOVING_PART = 0.05, 0.05  # rad/s, and of the largest velocity: slower is at rest


def initial_values(setting: PreparedCampaign) -> Values:
    """All numbers before any fit: the data's own start, and what is given."""
    campaign = setting.campaign
    B1 = setting.fixed["B1"]
    fitted = [setting.recordings[i] for i in setting.fitted]
    given = {n: v for n, v in setting.fixed.items() if n in ("B2", "k")}
    sigma = {"phi1": setting.sigma[0], "phi2": setting.sigma[1]}
    start = start_from_data(fitted, sigma, setting.widths[setting.fitted], B1, given)
    if setting.model == "paper":  # the printed model with all of the column's numbers doubled
        for name in ("B2", "Tv", "Ts1", "Tst"):
            if name in start and name not in given:
                start[name] *= 0.5
    middle, rate = (list(each) for each in zip(*(r.drift for r in setting.recordings), strict=True))
    clocks = [r.start for r in setting.recordings]
    if all(c is not None for c in clocks):  # drifts run on the campaign's clock
        begin = min(c + r.t[0] for c, r in zip(clocks, setting.recordings, strict=True))
        end = max(c + r.t[-1] for c, r in zip(clocks, setting.recordings, strict=True))
        middle = [0.5 * (begin + end) - c for c in clocks]
        rate = [1.0 / (end - begin)] * len(clocks)
    paper = setting.model == "paper"
    values: dict[str, object] = {
        "B1": B1,
        "B2": B1,
        "k": B1,
        "T0": 1.0,
        "eps1": setting.eps,
        "eps2": setting.eps,
        "reaction": PRINTED_REACTION if paper else NEWTON_REACTION,
        "omega": [r.omega if is_sine(r) else 0.0 for r in setting.recordings],
        "running": [float(is_sine(r)) for r in setting.recordings],
        "metered": [float(r.measured_drive) for r in setting.recordings],
        "drift_middle": middle,
        "drift_rate": rate,
    }
    out = Values.build(setting.layout, len(campaign.recordings), {**values, **start})
    return out.replace(setting.fixed)


def start_from_data(
    recordings: Sequence[Recording],
    sigma: dict[str, float],
    widths: Sequence[int] | np.ndarray,
    B1: float,
    given: dict[str, float],
) -> dict[str, float]:
    """Parameters by name from the recorded angles alone, within some ten per cent.

    Args:
        recordings: those to be fitted.
        sigma: noise by channel [rad].
        widths: of each, samples of the smoothing window.
        B1: inertia of the column [kg m^2].
        given: values known beforehand (B2, k).
    """
    rows: list[dict[str, np.ndarray]] = []
    for r, width in zip(recordings, map(int, widths), strict=True):
        one = local_polynomial(r.t, r.phi1, sigma["phi1"], width, ORDER)
        two = None
        if r.phi2 is not None:
            two = local_polynomial(r.t, r.phi2, sigma["phi2"], width, ORDER)
        inner = _inner(r.t, width)
        row = dict(t=r.t, y=one.value, v=one.first, a=one.second)
        n = r.t.size
        row["v2"], row["a2"] = (
            (np.zeros(n), np.zeros(n)) if two is None else (two.first, two.second)
        )
        row["sin"] = np.sin(r.omega * r.t) if is_sine(r) else np.zeros(n)
        row["cos"] = np.cos(r.omega * r.t) if is_sine(r) else np.zeros(n)
        row["reading"] = np.zeros(n) if r.drive is None else r.drive
        rows.append({k: v[inner] for k, v in row.items()})
    d = {k: np.concatenate([row[k] for row in rows]) for k in rows[0]}
    column = _column(d, B1, given, recordings)
    if recordings[0].phi2 is None:
        return column
    return {**column, **_contact(d, column["B2"])}


def _inner(t: np.ndarray, width: int) -> np.ndarray:
    """Samples (n,) bool with a smoothing window to both sides of them, or the middle of a stretch
    that is shorter than one."""
    inner = np.zeros(t.size, dtype=bool)
    for part in stretches(t):
        n = part.stop - part.start
        if n > ORDER:  # else nothing is known of its rates
            edge = (min(width, n) - 1) // 2
            inner[part.start + edge : part.stop - edge] = True
    return inner


def _column(d, B1, given, recordings) -> dict[str, float]:
    rider = recordings[0].phi2 is not None
    # where the column hardly moves the sign of its velocity is noise; a slow rig is slow throughout
    moving = np.abs(d["v"]) > min(MOVING, MOVING_PART * float(np.abs(d["v"]).max()))
    terms = {"k": d["y"], "c1": d["v"], "M1": np.sign(d["v"]) * moving}
    if rider:
        terms["B2"] = d["a"] + d["a2"]
    if any(is_sine(r) for r in recordings):
        terms |= {"ks": -d["sin"], "kc": -d["cos"]}
    if any(r.drive is not None for r in recordings):
        terms |= {"kg": -d["reading"]}
    terms |= {"kz": -np.ones_like(d["y"])}
    target = -B1 * d["a"]
    for name in ("B2", "k"):
        if name in given and name in terms:
            target = target - given[name] * terms.pop(name)
    A = np.stack(list(terms.values()), axis=1)
    norm = np.sqrt((A**2).mean(axis=0))
    positive = np.array([n in ("k", "c1", "M1", "B2") for n in terms])
    lower = np.where(positive, 0.0, -np.inf)
    there = norm > 0.0  # of a column that never moves nothing is known of its friction
    x = np.zeros(norm.size)
    x[there] = _bounded(A[:, there] / norm[there], target, lower[there]).x / norm[there]
    v = {**dict(zip(terms, x, strict=True)), **given}
    k = v["k"] = max(v["k"], 1e-9)
    out = {"k": k, "c1": v["c1"], "M1": max(v["M1"], 1e-3 * np.abs(target).std())}
    if rider:
        out["B2"] = max(v["B2"], 1e-3 * B1)
    if "ks" in v:
        out["A"] = max(float(np.hypot(v["ks"], v["kc"])) / k, 1e-3)
        out["phase"] = float(np.arctan2(v["kc"], v["ks"]))
    if "kg" in v:
        out["gain"] = v["kg"] / k
        out["level"] = v["kz"] / k
    else:
        out["zero1"] = v["kz"] / k
    return {n: float(x) for n, x in out.items()}


def _bounded(A, y, lower):
    # SciPy's trust region scales by the distance to bounds, and multiplies infinite ones by 0.
    with np.errstate(invalid="ignore"):
        return lsq_linear(A, y, (lower, np.full(A.shape[1], np.inf)))


def _contact(d, B2) -> dict[str, float]:
    sliding = np.abs(d["v2"]) > max(0.1, 0.1 * float(np.abs(d["v2"]).max()))
    torque = -B2 * (d["a"] + d["a2"])
    size = float(np.abs(torque).max())
    if sliding.sum() < 20:  # the rider never slides: only a lower bound of the friction is known
        return {"Tv": 1e-3 * size, "Ts1": 1.5 * size, "Tst": 0.1 * size, "T0": 4.0}
    v, y = d["v2"][sliding], torque[sliding]
    best, fit = np.inf, np.zeros(3)
    T0 = 4.0
    for rate in T0_GRID:
        A = np.stack([v, np.sign(v), np.sign(v) * -np.expm1(-rate * np.abs(v))], axis=1)
        norm = np.sqrt((A**2).mean(axis=0))
        trial = _bounded(A / norm, y, np.zeros(3))
        if trial.cost < best:
            best, fit, T0 = trial.cost, trial.x / norm, rate
    floor = 0.02 * np.abs(y).mean()
    Tv, Ts1, Tst = fit
    return {
        "Tv": float(Tv),
        "Ts1": float(max(Ts1, floor)),
        "Tst": float(max(Tst, floor)),
        "T0": float(T0),
    }
