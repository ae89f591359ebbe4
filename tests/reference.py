"""The pendulum and the effects written anew in plain Python, integrated by SciPy.

What the package is held to. Nothing of the package is used here, so that an error in its equations
or its integrator cannot hide in both.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from types import SimpleNamespace

import numpy as np
from scipy.integrate import odeint

#: Section 5.1 of the paper, and this project's bench.
PAPER = dict(
    B1=20.0,
    B2=1.0,
    k=100.0,
    A=math.pi / 6,
    omega=0.5,
    c1=10.0,
    M1=3.0,
    Tv=1.0,
    Ts1=2.0,
    Ts2=2.0,
    Tst=0.5,
    T0=10.0,
    eps=1000.0,
    reaction=2.0,
)
BENCH = dict(
    B1=1.2e-3,
    B2=5.0e-4,
    k=0.45,
    A=0.18,
    omega=13.09,
    c1=2.2e-3,
    M1=5.0e-3,
    Tv=2.5e-4,
    Ts1=1.25e-2,
    Ts2=0.0,
    Tst=2.5e-3,
    T0=4.0,
    eps=5.0e4,
    reaction=1.0,
)

#: What may be multiplied by one number without a change of the motion.
SCALED = ("B1", "B2", "k", "c1", "M1", "Tv", "Ts1", "Ts2", "Tst")

Numbers = Mapping[str, float]

#: Effect -> quantity it replaces, and that quantity with its amplitudes: the catalogue's column
#: "exactly". rate: true seconds per recorded second; theta, f: phase and angle of the drive;
#: spring, ML, MT: torques; column: sum of the torques on the column; y1, y2: readings.
FORMULAS: dict[str, tuple[str, Callable[..., float]]] = {
    "drive_harmonics": (
        "f",
        lambda q, a, b: (
            q.A * (math.sin(q.theta) + a * math.sin(2 * q.theta) + b * (math.cos(2 * q.theta) - 1))
        ),
    ),
    "drive_frequency": ("theta", lambda q, a: (q.omega + a) * q.t),
    "drive_steps": ("theta", lambda q, a, q_: q.theta + a * (q_ * round(q.theta / q_) - q.theta)),
    "spring_asymmetry": ("spring", lambda q, a: q.k * (q.d + a * abs(q.d))),
    "spring_hardening": ("spring", lambda q, a: q.k * (q.d + a * q.d**3)),
    "spring_relaxation": ("spring", lambda q, a: q.k * (1 + a * q.s) * q.d),
    "bearing_stribeck": (
        "ML",
        lambda q, a, vs: q.c1 * q.v1 + q.M1 * q.S1 * (1 + a * math.exp(-((q.v1 / vs) ** 2))),
    ),
    "bearing_position": (
        "ML",
        lambda q, a, b, n: (
            q.c1 * q.v1 + q.M1 * q.S1 * (1 + a * math.cos(n * q.phi1) + b * math.sin(n * q.phi1))
        ),
    ),
    "bearing_drag": ("ML", lambda q, a: q.c1 * q.v1 + q.M1 * q.S1 + a * q.v1 * abs(q.v1)),
    "bearing_warmup": ("ML", lambda q, a: (q.c1 * q.v1 + q.M1 * q.S1) * (1 + a * q.s)),
    "bearing_asymmetry": ("ML", lambda q, a: q.c1 * q.v1 + q.M1 * (q.S1 + a * abs(q.S1))),
    "bearing_load": ("ML", lambda q, a: q.c1 * q.v1 + q.M1 * q.S1 * (1 + a * abs(q.spring) / q.M1)),
    # below zero, where there is no gap, the formula goes on although physics does not
    "spring_deadzone": (
        "spring",
        lambda q, g: q.k * (q.d - math.copysign(1.0, q.d) * min(abs(q.d), g)),
    ),
    "contact_stribeck": (
        "MT",
        lambda q, a, vs: q.Tv * q.v2 + q.dry2 * (1 + a * math.exp(-((q.v2 / vs) ** 2))),
    ),
    "contact_position": (
        "MT",
        lambda q, a, b, n: (
            q.Tv * q.v2 + q.dry2 * (1 + a * math.cos(n * q.phi2) + b * math.sin(n * q.phi2))
        ),
    ),
    "contact_wear": ("MT", lambda q, a: q.Tv * q.v2 + q.dry2 * (1 + a * q.s)),
    # M1 (S + a |S|) of the bearing on the dry terms: both change by the same part of themselves
    "contact_asymmetry": ("MT", lambda q, a: q.Tv * q.v2 + q.dry2 + a * abs(q.dry2)),
    "contact_vibration": (
        "MT",
        lambda q, a, b, W: (
            q.Tv * q.v2
            + q.dry2
            * (1 + a * math.cos(2 * math.pi * W * q.t) + b * math.sin(2 * math.pi * W * q.t))
        ),
    ),
    "contact_cogging": (
        "MT",
        lambda q, a, b, n: (
            q.Tv * q.v2 + q.dry2 + a * math.sin(n * q.phi2) + b * math.cos(n * q.phi2)
        ),
    ),
    "contact_repeatability": ("MT", lambda q, a: q.Tv * q.v2 + q.dry2 + a * q.Ts1 * q.S2),
    "column_tilt": (
        "column",
        lambda q, a, b: q.column - (a * math.sin(q.phi1) + b * math.cos(q.phi1)),
    ),
    "elastic_stop": (
        "column",
        lambda q, a, b, s: (
            q.column - (a * (q.phi1 - s) if q.phi1 > s else b * (q.phi1 + s) if q.phi1 < -s else 0)
        ),
    ),
    "sensor1_eccentricity": (
        "y1",
        lambda q, a, b: q.phi1 + a * math.sin(q.phi1) + b * (math.cos(q.phi1) - 1),
    ),
    "sensor2_eccentricity": (
        "y2",
        lambda q, a, b: q.phi2 + a * math.sin(q.phi2) + b * (math.cos(q.phi2) - 1),
    ),
    "sensor1_interpolation": (
        "y1",
        lambda q, a, b, n: q.phi1 + a * math.sin(n * q.phi1) + b * (math.cos(n * q.phi1) - 1),
    ),
    "sensor2_interpolation": (
        "y2",
        lambda q, a, b, n: q.phi2 + a * math.sin(n * q.phi2) + b * (math.cos(n * q.phi2) - 1),
    ),
    "sensor1_nonlinearity": ("y1", lambda q, a: q.phi1 + a * (math.sin(2 * q.phi1) / 2 - q.phi1)),
    "sensor2_nonlinearity": ("y2", lambda q, a: q.phi2 + a * (math.sin(2 * q.phi2) / 2 - q.phi2)),
    "sensor1_drift": ("y1", lambda q, a, b: q.phi1 * (1 + a * q.s) + b * q.s),
    "sensor2_drift": ("y2", lambda q, a, b: q.phi2 * (1 + a * q.s) + b * q.s),
    "sensor_crosstalk": ("y2", lambda q, a: q.phi2 + a * q.phi1),
    # phi2(t - a) by its first terms; that these are enough has a test of its own
    "channel_delay": ("y2", lambda q, a: q.phi2 - a * q.v2 + a**2 / 2 * q.a2),
    "clock_skew": ("rate", lambda q, a: 1 / (1 + a)),
    "reaction_factor": ("column", lambda q, a: q.spring - q.ML + (1 + a) * q.MT),
}


def instant(
    p: Numbers, t: float, y: Sequence[float], effect: str = "", values: Numbers | None = None
) -> SimpleNamespace:
    """All quantities of one instant, by equations (3b), (5), (6) without Ts2, and (16).

    Args:
        p: parameters; optionally `phase`, and `middle` and `drift` of s = (t - middle) drift.
        t: recorded time. y: phi1, phi2, v1, v2.
        effect: one of FORMULAS. values: its amplitudes and shape constants.
    """
    stage, formula = FORMULAS[effect] if effect else ("", lambda q: 0.0)
    # `q` is taken by the quantities
    given = {"q_" if name == "q" else name: value for name, value in (values or {}).items()}
    q = SimpleNamespace(**p)
    q.phi1, q.phi2, q.v1, q.v2 = y

    def put(name: str, value: float) -> None:
        setattr(q, name, value)
        if name == stage:
            setattr(q, name, formula(q, **given))

    put("rate", 1.0)
    q.t = t * q.rate
    q.s = (q.t - p.get("middle", 0.0)) * p.get("drift", 0.0)
    put("theta", q.omega * q.t + p.get("phase", 0.0))
    put("f", q.A * math.sin(q.theta))
    q.d = q.f - q.phi1
    q.S1 = 2.0 / math.pi * math.atan(q.eps * q.v1)
    q.S2 = 2.0 / math.pi * math.atan(q.eps * q.v2)
    q.dry2 = q.Ts1 * q.S2
    q.dry2 -= q.Tst * math.expm1(-q.T0 * abs(q.v2)) * math.copysign(1.0, q.v2)
    put("spring", q.k * q.d)
    put("ML", q.c1 * q.v1 + q.M1 * q.S1)
    put("MT", q.Tv * q.v2 + q.dry2)
    put("column", q.spring - q.ML + q.reaction * q.MT)
    q.a1 = q.column / q.B1
    q.a2 = -q.MT / q.B2 - q.a1
    put("y1", q.phi1)
    put("y2", q.phi2)
    return q


def right_hand_side(
    p: Numbers, effect: str = "", values: Numbers | None = None
) -> Callable[[float, Sequence[float]], list[float]]:
    """f(t, y) in recorded time, y = phi1, phi2, v1, v2."""

    def f(t: float, y: Sequence[float]) -> list[float]:
        q = instant(p, t, y, effect, values)
        return [q.rate * x for x in (q.v1, q.v2, q.a1, q.a2)]

    return f


def reference(
    p: Numbers,
    ts: np.ndarray,
    y0: Sequence[float] = (0.0, 0.0, 0.0, 0.0),
    effect: str = "",
    values: Numbers | None = None,
    rtol: float = 1e-10,
    atol: float = 1e-12,
) -> np.ndarray:
    """Motion (n, 4) at times `ts`, by LSODA."""
    f = right_hand_side(p, effect, values)
    return odeint(f, y0, ts, tfirst=True, rtol=rtol, atol=atol, mxstep=1_000_000, hmax=0.01)


def readings(
    p: Numbers,
    ts: np.ndarray,
    ys: np.ndarray,
    effect: str = "",
    values: Numbers | None = None,
) -> np.ndarray:
    """What the sensors report (n, 2) along a motion."""
    at = [instant(p, t, y, effect, values) for t, y in zip(ts.tolist(), ys.tolist(), strict=True)]
    return np.array([[q.y1, q.y2] for q in at])
