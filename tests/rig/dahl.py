"""The catalogue's effects with states, as the catalogue states them, on the smoothed pendulum.

Dahl's z' = v - |v| z / z0 where the rig has networks of sliders; a base without a body of its own
where the rig has one; the play operator taken over a table of the drive.
"""

import math
from collections.abc import Mapping

import numpy as np
from scipy.integrate import odeint

EFFECTS = (
    "spring_hysteresis",
    "bearing_presliding",
    "contact_presliding",
    "column_cable",
    "base_compliance",
    "drive_backlash",
)


def smoothed(
    p: Mapping[str, float],
    ts: np.ndarray,
    effect: str = "",
    values: Mapping[str, float] | None = None,
) -> np.ndarray:
    """phi1, phi2 (n, 2) [rad] from rest; parameters and smoothing as in `tests.reference`."""
    v = dict(values or {})
    a, z0 = v.get("a", 0.0), v.get("z0", 1.0)
    W, zeta = 2 * math.pi * v.get("W", 1.0), v.get("zeta", 0.0)
    is_ = {name: effect == name for name in EFFECTS}
    table = np.arange(0.0, ts[-1] + 0.02, 1e-5)
    played = p["A"] * np.sin(p["omega"] * table)
    if is_["drive_backlash"]:
        played = play(played, v["g"])

    def rhs(t, y):
        phi1, _phi2, v1, v2, z, psi, dpsi = y
        if is_["drive_backlash"]:
            f = float(np.interp(t, table, played))
        else:
            f = p["A"] * math.sin(p["omega"] * t)
        df = p["A"] * p["omega"] * math.cos(p["omega"] * t)
        d = f - phi1
        S1, S2 = (2 / math.pi * math.atan(p["eps"] * x) for x in (v1, v2))
        dry2 = p["Ts1"] * S2 - p["Tst"] * math.expm1(-p["T0"] * abs(v2)) * math.copysign(1.0, v2)
        size2 = p["Ts1"] - p["Tst"] * math.expm1(-p["T0"] * abs(v2))
        spring, bearing = p["k"] * d, p["c1"] * v1 + p["M1"] * S1
        contact, column, moves = p["Tv"] * v2 + dry2, 0.0, 0.0
        if is_["spring_hysteresis"]:
            spring, moves = p["k"] * (d + a * z), df - v1
        elif is_["bearing_presliding"]:
            bearing, moves = p["c1"] * v1 + p["M1"] * ((1 - a) * S1 + a * z / z0), v1
        elif is_["contact_presliding"]:
            contact, moves = p["Tv"] * v2 + (1 - a) * dry2 + a * size2 * z / z0, v2
        elif is_["column_cable"]:
            column, moves = -a * z, v1
        ddpsi = 0.0
        if is_["base_compliance"]:
            ddpsi = -2 * zeta * W * dpsi - W**2 * psi - a * (spring - bearing) / p["B1"]
        own = (spring - bearing + contact + column) / p["B1"]
        dz = moves - abs(moves) * z / z0
        return [v1, v2, own - ddpsi, -contact / p["B2"] - own, dz, dpsi, ddpsi]

    y = odeint(rhs, [0.0] * 7, ts, tfirst=True, rtol=1e-9, atol=1e-11, mxstep=10**6, hmax=0.002)
    return y[:, :2]


def play(x: np.ndarray, half: float) -> np.ndarray:
    """The play operator of half width `half` along a row of inputs, from 0."""
    y, out = 0.0, []
    for each in x.tolist():
        y = min(max(y, each - half), each + half)
        out.append(y)
    return np.array(out)
