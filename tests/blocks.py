"""Information of blocks as tests make it up: of all columns in every block."""

import numpy as np

from tp_jax.gap.block_information import BlockInformation


def whole(joint: np.ndarray, effects: int | None = None) -> BlockInformation:
    """Returns it from covariances (B, E + u, E + u) of efficient scores and gradients by unknowns.

    Args:
        joint: the covariances. effects: E, all columns if None.
    """
    n = joint.shape[1]
    effects = n if effects is None else effects
    to = np.tile(np.arange(n), (len(joint), 1))
    return BlockInformation(joint, to, np.zeros((n - effects, effects)))
