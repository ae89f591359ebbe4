"""Bounded numbers in coordinates without bounds, for methods that know none.

Source: James (1994), MINUIT, CERN Program Library D506, Section 1.2: a sine between two bounds,
a hyperbola above one. Both reach the bound, and leave it again.
"""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float


class Unbounded(NamedTuple):
    """lower, upper: (n,) bounds, infinite where there is none.

    Example:
        >>> import numpy as np
        >>> box = Unbounded(np.array([0.0, -np.inf, 1.0]), np.array([np.inf, np.inf, 3.0]))
        >>> x = np.array([0.5, -7.0, 2.5])
        >>> bool(np.allclose(box.inside(box.outside(x)), x))
        True
    """

    lower: Float[Array, " n"]
    upper: Float[Array, " n"]

    def inside(self, v: Float[Array, " n"]) -> Float[Array, " n"]:
        """Bounded numbers at coordinates v."""
        two = jnp.isfinite(self.lower) & jnp.isfinite(self.upper)
        low = jnp.where(jnp.isfinite(self.lower), self.lower, 0.0)
        high = jnp.where(jnp.isfinite(self.upper), self.upper, 0.0)
        between = low + 0.5 * (high - low) * (jnp.sin(v) + 1.0)
        arm = jnp.sqrt(v**2 + 1.0) - 1.0
        kinds = [two, jnp.isfinite(self.lower), jnp.isfinite(self.upper)]
        return jnp.select(kinds, [between, low + arm, high - arm], v)

    def outside(self, x: np.ndarray) -> np.ndarray:
        """Coordinates of bounded numbers: those on the side that grows with the number."""
        low, high = np.asarray(self.lower), np.asarray(self.upper)
        out = np.array(x, dtype=float)
        for i, (a, b, value) in enumerate(zip(low, high, out, strict=True)):
            if np.isfinite(a) and np.isfinite(b):
                share = 2.0 * (np.clip(value, a, b) - a) / max(b - a, 1e-300) - 1.0
                out[i] = np.arcsin(np.clip(share, -1.0, 1.0))
            elif np.isfinite(a):
                out[i] = np.sqrt((max(value - a, 0.0) + 1.0) ** 2 - 1.0)
            elif np.isfinite(b):
                out[i] = -np.sqrt((max(b - value, 0.0) + 1.0) ** 2 - 1.0)
        return out
