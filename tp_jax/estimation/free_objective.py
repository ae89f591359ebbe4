"""The paper's objective (17): free runs over whole recordings, all of them as lanes."""

import functools

import jax
import jax.numpy as jnp
import numpy as np

from tp_jax.estimation.baseline import Setting
from tp_jax.estimation.layout import Layout, Values
from tp_jax.simulation.lanes import Lanes, integrate


class FreeRunObjective:
    """y = mean over recordings of (17): half the sum of the channels' mean squared errors.

    Initial states are the smoothed first readings. With one channel, its mean square.
    """

    def __init__(self, setting: Setting):
        self.setting = setting
        self.layout = Layout(setting.campaign.model, ())
        self.which = setting.fitted
        data = [setting.prepared[i] for i in self.which]
        n = max(d.t.size for d in data)
        self.count = np.array([d.t.size for d in data])
        self.ts = np.stack([np.pad(d.t, (0, n - d.t.size), mode="edge") for d in data], axis=1)
        self.y = np.zeros((n, 2, len(data)))
        self.weight = np.zeros((n, 2, len(data)))
        self.states = np.zeros((n, 4, len(data)))
        measured = any(d.pieces is not None for d in data)
        self.pieces = np.zeros((n - 1, 4, len(data))) if measured else None
        for j, d in enumerate(data):
            m = d.t.size
            self.y[:m, :, j] = d.y
            self.weight[:m, :, j] = d.channels / d.channels.sum() / m / len(data)
            self.states[0, :, j] = d.smooth[0]
            if self.pieces is not None and d.pieces is not None:
                self.pieces[: m - 1, :, j] = d.pieces

    def __call__(self, values: Values) -> float:
        """y [rad^2]; infinite where a run could not be integrated."""
        p = values.table[: len(self.layout.parameters), self.which]
        y = _readings(
            self.layout, jnp.asarray(p), jnp.asarray(self.states), jnp.asarray(self.ts),
            jnp.asarray(self.count), self.pieces,
        )  # fmt: skip
        total = float((self.weight * (np.asarray(y) - self.y) ** 2).sum())
        return total if np.isfinite(total) else np.inf


@functools.partial(jax.jit, static_argnums=0)
def _readings(layout, p, states, ts, count, pieces):
    slots = tuple(p)

    def field(t, y, q, piece, left):
        return layout.model(q, piece, left).derivative(t, y)

    start = jnp.zeros(ts.shape, bool)
    eps = (layout.index["eps1"], layout.index["eps2"])
    lanes = Lanes(ts, count, start, states, pieces)
    none = jnp.zeros(0, int)
    run = integrate(field, slots, lanes, eps, none, (), max_steps=400_000)
    y = tuple(jnp.moveaxis(run.y, 2, 0).transpose(0, 2, 1))
    wide = tuple(jnp.broadcast_to(q, ts.shape) for q in slots)
    out = jnp.stack(layout.model(wide).readings(ts, y), axis=1)
    return jnp.where(run.complete, out, jnp.inf)
