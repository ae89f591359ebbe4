"""End of a search from one start, as numbers that a file can hold."""

import dataclasses
import math
from typing import Any

import numpy as np

from tp_jax.errors import InputError
from tp_jax.estimation.fitted import Fit, parameter
from tp_jax.estimation.layout import Values


@dataclasses.dataclass(frozen=True)
class Outcome:
    """Attributes:
    x: (u,) unknowns, SI units.
    cost: chi-square of the windows; infinite where they could not be integrated.
    chi2_dof: by degrees of freedom.
    information: (u, u) of the unknowns in their estimation coordinates; zeros where unknown.
    evaluations: passes over the data.
    converged, message: how the method ended.
    objective: what it minimised: chi-square, or y of (17) [rad^2].
    states: (w, 4) of the windows, or None.
    """

    x: np.ndarray
    cost: float
    chi2_dof: float
    information: np.ndarray
    evaluations: int
    converged: bool
    message: str
    objective: float
    states: np.ndarray | None = None

    @classmethod
    def of(
        cls, fit: Fit, *, keep_states: bool = False, objective: float | None = None
    ) -> "Outcome":
        """Makes the outcome of a fit."""
        specs = [parameter(fit.problem, u) for u in fit.unknowns]
        x = fit.values.pick(fit.unknowns)
        slope = np.array([s.slope(v) for s, v in zip(specs, x, strict=True)])
        H = fit.information() * np.outer(slope, slope)
        finite = bool(np.isfinite(fit.cost))
        return cls(
            x,
            float(fit.cost),
            float(fit.chi2_dof) if finite else np.inf,
            np.where(np.isfinite(H), H, 0.0),
            fit.evaluations,
            bool(fit.converged),
            fit.message,
            float(fit.cost if objective is None else objective),
            fit.states if keep_states else None,
        )

    @classmethod
    def failed(cls, x: np.ndarray, message: str) -> "Outcome":
        """Makes the outcome of a start from which nothing came."""
        n = x.size
        return cls(x, np.inf, np.inf, np.zeros((n, n)), 0, False, message, np.inf)

    def to_dict(self) -> dict[str, Any]:
        """Returns the outcome for JSON: lists, and null for what is infinite."""
        out: dict[str, Any] = {}
        for name, value in dataclasses.asdict(self).items():
            if isinstance(value, np.ndarray):
                entries = value.astype(object)
                entries[~np.isfinite(value)] = None
                out[name] = entries.tolist()
            else:
                finite = not isinstance(value, float) or math.isfinite(value)
                out[name] = value if finite else None
        return out

    @classmethod
    def from_dict(cls, stored: dict[str, Any]) -> "Outcome":
        """The same again, to the last digit.

        Raises:
            InputError: its arrays are none, or do not belong together.
        """
        try:
            arrays = {
                n: None if stored[n] is None else np.array(stored[n], dtype=float)
                for n in ("x", "information", "states")
            }
            x, H, states = arrays.values()
            fits = x is not None and H is not None and x.ndim == 1 and H.shape == (x.size, x.size)
            fits &= states is None or (states.ndim == 2 and states.shape[1] == 4)
        except (AttributeError, TypeError, ValueError, OverflowError):
            fits = False
        if not fits:
            raise InputError(
                "A start that was kept has other numbers than it ended with; start without "
                "--resume."
            )
        numbers = {
            n: np.inf if stored[n] is None else stored[n] for n in ("cost", "chi2_dof", "objective")
        }
        return cls(**{**stored, **arrays, **numbers})

    def values(self, base: Values, unknowns) -> Values:
        """All numbers, those of `base` but for the unknowns."""
        return base.put(unknowns, self.x)
