"""Settings of a study."""

from typing import NamedTuple

from tp_jax.model.parameters import SHARPEST_EPS


class Settings(NamedTuple):
    """runs: recordings of a campaign, the first a decay; duration [s]; rate [Hz]; noise [rad];
    bits of the converter; seed of the rigs; eps: sharpest friction of a fit [s]."""

    runs: int = 6
    duration: float = 10.0
    rate: float = 250.0
    noise: float = 1e-3
    bits: int = 16
    seed: int = 0
    eps: float = SHARPEST_EPS


QUICK = Settings(runs=3, duration=4.0)
