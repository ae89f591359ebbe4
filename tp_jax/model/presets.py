"""Parameter sets with a name.

Source: Czerwinski, Olejnik, Awrejcewicz (2015), Section 5.1; `bench` is this project's own rig,
the size of a laboratory stand, on which benchmarks run.
"""

import math
from typing import Any

from jax.typing import ArrayLike

from tp_jax.model.bearing import Bearing
from tp_jax.model.contact import Contact
from tp_jax.model.drive import SineDrive
from tp_jax.model.parameters import DEFAULT_EPS, PAPER_EPS
from tp_jax.model.pendulum import (
    NEWTON_REACTION,
    PRINTED_REACTION,
    DoubleTorsionPendulum,
    SingleTorsionPendulum,
)
from tp_jax.model.spring import LinearSpring

_PRESETS: dict[str, dict[str, float]] = {
    "paper-5.1": dict(
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
        eps=PAPER_EPS,
        reaction=PRINTED_REACTION,
    ),
    "paper-5.1-start": dict(
        B1=22.0,
        B2=11.0,
        k=10.0,
        A=math.pi / 4,
        omega=0.5,
        c1=5.0,
        M1=2.0,
        Tv=0.1,
        Ts1=3.0,
        Ts2=1.0,
        Tst=0.2,
        T0=1000.0,
        eps=PAPER_EPS,
        reaction=PRINTED_REACTION,
    ),
    "bench": dict(
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
        eps=DEFAULT_EPS,
        reaction=NEWTON_REACTION,
    ),
}


def names() -> tuple[str, ...]:
    """Names of the presets."""
    return tuple(_PRESETS)


def values(name: str) -> dict[str, float]:
    """Parameters of a preset in SI units, by name.

    Raises:
        KeyError: if there is no preset of that name; the message lists those there are.
    """
    if name not in _PRESETS:
        raise KeyError(f"There is no preset {name!r}, choose one of: {', '.join(_PRESETS)}.")
    return dict(_PRESETS[name])


def get(name: str) -> DoubleTorsionPendulum:
    """The pendulum of a preset; see `values`."""
    numbers: dict[str, Any] = values(name)
    return double_pendulum(**numbers)


def double_pendulum(
    *,
    B1: ArrayLike,
    B2: ArrayLike,
    k: ArrayLike,
    A: ArrayLike,
    omega: ArrayLike,
    c1: ArrayLike,
    M1: ArrayLike,
    Tv: ArrayLike,
    Ts1: ArrayLike,
    Tst: ArrayLike,
    T0: ArrayLike,
    Ts2: ArrayLike = 0.0,
    eps: ArrayLike = DEFAULT_EPS,
    phase: ArrayLike = 0.0,
    reaction: ArrayLike = NEWTON_REACTION,
    terms: tuple = (),
) -> DoubleTorsionPendulum:
    """A sine-driven double torsion pendulum from plain numbers in SI units."""
    return DoubleTorsionPendulum(
        drive=SineDrive(A=A, omega=omega, offset=phase),
        spring=LinearSpring(k),
        bearing=Bearing(c1=c1, M1=M1, eps=eps),
        contact=Contact(Tv=Tv, Ts1=Ts1, Ts2=Ts2, Tst=Tst, T0=T0, eps=eps),
        B1=B1,
        B2=B2,
        reaction=reaction,
        terms=terms,
    )


def single_pendulum(
    *,
    B1: ArrayLike,
    k: ArrayLike,
    A: ArrayLike,
    omega: ArrayLike,
    c1: ArrayLike,
    M1: ArrayLike,
    eps: ArrayLike = DEFAULT_EPS,
    phase: ArrayLike = 0.0,
    terms: tuple = (),
) -> SingleTorsionPendulum:
    """A sine-driven column without a rider, from plain numbers in SI units.

    Example:
        >>> column = single_pendulum(B1=1.2e-3, k=0.45, A=0.18, omega=13.09, c1=2.2e-3, M1=5e-3)
    """
    return SingleTorsionPendulum(
        drive=SineDrive(A=A, omega=omega, offset=phase),
        spring=LinearSpring(k),
        bearing=Bearing(c1=c1, M1=M1, eps=eps),
        B1=B1,
        terms=terms,
    )


def __getattr__(name: str) -> DoubleTorsionPendulum:
    """`presets.paper_5_1`, `presets.bench`: attributes for interactive use."""
    for key in _PRESETS:
        if name == key.replace("-", "_").replace(".", "_"):
            return get(key)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
