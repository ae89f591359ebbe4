"""Conversion of parameters to float64 arrays, and types of what NumPy and JAX take."""

import jax.numpy as jnp
import numpy as np
from jax.typing import ArrayLike
from jaxtyping import Array, Float

import tp_jax._float64  # noqa: F401

AnyArray = Array | np.ndarray

#: A real number, or an array of them of any shape.
Real = Float[AnyArray, "..."] | float


def as_float(x: ArrayLike) -> Float[Array, "..."]:
    """Turns a number into a floating-point array.

    Fields of the modules pass through here, since a Python float as a leaf would make every new
    value a new program.
    """
    return jnp.asarray(x, dtype=float)
