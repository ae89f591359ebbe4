"""Recordings with far more samples than their motion needs, averaged over blocks.

White noise is averaged away as well before a fit as in it, so nothing is lost but time. The mean
over a block of length h weakens what turns at w by (w h)^2 / 24.

Where steps of the readings hide their noise, one reading of each block is taken instead. Rounding
then goes with the motion, that of neighbouring readings alike: their mean is hardly better than one
of them, but its steps are as fine as the block is long, and would pass for steps that hide nothing.
"""

import dataclasses

import numpy as np

from tp_jax.recordings.gaps import stretches
from tp_jax.recordings.recording import Recording


@dataclasses.dataclass(frozen=True)
class ThinPolicy:
    """Numbers of samples that are enough.

    Attributes:
        per_period: samples in a period of the motion that a recording keeps at least. With 256 the
            mean over a block weakens the motion by 2.5e-5 and its fifth harmonic by 6e-4, less than
            such recordings tell.
        shortest: samples of a recording below which it stays as it is: there is no time to gain.
    """

    per_period: int = 256
    shortest: int = 1024


POLICY = ThinPolicy()


def block_length(recording: Recording, period: float, policy: ThinPolicy = POLICY) -> int:
    """Samples that may be averaged; 1 where none are to spare.

    Args:
        recording: what was recorded. period: of its motion, typically [s]. policy: what is enough.
    """
    step = float(np.median(np.diff(recording.t))) if recording.t.size > 1 else period
    if recording.t.size < policy.shortest:
        return 1
    return max(1, int(period / step / policy.per_period))


def thinned(recording: Recording, length: int, *, coarse: bool = False) -> Recording:
    """The recording with the mean of every `length` samples in their place.

    No block reaches across a gap; samples at the end of a stretch that fill no block are left out.

    Args:
        recording: what was recorded. length: see `block_length`.
        coarse: whether the sample in the middle of each block stands for it instead.
    """
    if length <= 1:
        return recording
    blocks = []
    for part in stretches(recording.t):
        count = (part.stop - part.start) // length
        blocks.append(part.start + length * np.arange(count))
    first = np.concatenate(blocks)
    members = first[:, None] + (length // 2 if coarse else np.arange(length))
    means = {
        name: values[members].mean(axis=1)
        for name in ("t", "phi1", "phi2", "drive")
        if (values := getattr(recording, name)) is not None
    }
    return dataclasses.replace(recording, **means)
