"""An effect of one's own, tried on a few motions before anything is fitted with it."""

import numpy as np

from tp_jax.effects.base import Applied, Effect
from tp_jax.model.presets import double_pendulum, values

NEEDS = frozenset({"rider", "sine", "measured", "several", "inertias"})
"""Conditions of a campaign that an effect may need."""

_STATES = 16


def tried(effect: Effect) -> None:
    """Evaluates an effect on random motions of the bench, at zero and at its typical size.

    Raises:
        ValueError: it cannot be evaluated, or is not a finite number of the right shape; the
            message names the effect and what to mend.
    """
    unknown = sorted(effect.needs - NEEDS)
    if unknown:
        raise ValueError(
            f"Effect {effect.id} needs {', '.join(unknown)}, but a campaign can have only "
            f"{', '.join(sorted(NEEDS))}."
        )
    if effect.reads_later or "measured" in effect.needs:  # no such drive is at hand here
        return
    random = np.random.default_rng(0)
    t = random.uniform(0.0, 10.0, _STATES)
    state = tuple(random.uniform(-2.0, 2.0, _STATES) for _ in range(4 + effect.n_states))
    shapes = {shape.name: shape.grid[len(shape.grid) // 2] for shape in effect.shapes}
    for size in (0.0, 1.0):
        sizes = {a.name: size * _within(a.typical, a.lower, a.upper) for a in effect.amplitudes}
        model = double_pendulum(**values("bench"), terms=(Applied(effect, sizes | shapes),))
        try:
            with np.errstate(all="ignore"):
                found = (*model.derivative(t, state), *model.readings(t, state))
                # broadcasting would let a wrong shape pass where it meets a number
                whole = all(np.shape(each) == (_STATES,) for each in found)
                finite = all(bool(np.isfinite(each).all()) for each in found)
        except Exception as fault:  # whatever somebody else's formula may raise
            why = " ".join(f"{type(fault).__name__}: {fault}".split()).rstrip(".")
            names = ", ".join(["self", "m", *sizes, *shapes])
            raise ValueError(
                f"Effect {effect.id} cannot be evaluated ({why}); its functions are given "
                f"({names}), and a motion as tp_jax.model.motion.Motion describes it."
            ) from fault
        if not (whole and finite):
            what = "no finite number" if whole else "not of the motion's shape"
            raise ValueError(
                f"Effect {effect.id} is {what} for angles and velocities within 2 rad and rad/s, "
                f"with {', '.join(f'{n} = {v:g}' for n, v in sizes.items())}; mend its formula "
                "there, as by abs() or jnp.where."
            )


def _within(typical: float, lower: float, upper: float) -> float:
    """A size that is physical: the other sign where only that is."""
    return typical if lower <= typical <= upper else float(np.clip(-typical, lower, upper))
