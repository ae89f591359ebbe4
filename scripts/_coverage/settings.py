"""What a study consists of."""

from typing import NamedTuple


class Settings(NamedTuple):
    """runs: recordings of a campaign, the first a decay; duration [s]; rate [Hz]; noise [rad];
    bits of the converter; seed of the rigs."""

    runs: int = 6
    duration: float = 10.0
    rate: float = 250.0
    noise: float = 1e-3
    bits: int = 16
    seed: int = 0


QUICK = Settings(runs=3, duration=4.0)
