"""Linear rigs by NumPy alone, which share an effect or do not, and what their screens say."""

import numpy as np

from tp_jax.gap.shared.scores import RigScores, ScoredVariant

EFFECTS = ("a", "b", "c", "d", "two")
SAMPLES, NUISANCES = 80, 3
FREE = (-np.inf, np.inf)


class Rig:
    """Readings of a rig: y = N n + X e + noise, with numbers n of its own.

    X has a column for each effect, two for the last; `d` much resembles `c`.
    """

    def __init__(self, rng, amplitudes=(0.0,) * 6, alike=0.05, limits=FREE, missing=()):
        self.X = rng.standard_normal((SAMPLES, 6)) * rng.uniform(0.7, 1.4)
        self.X[:, 3] = self.X[:, 2] + alike * rng.standard_normal(SAMPLES)
        self.N = rng.standard_normal((SAMPLES, NUISANCES))
        own = self.N @ rng.standard_normal(NUISANCES)
        self.y = own + self.X @ np.asarray(amplitudes) + rng.standard_normal(SAMPLES)
        self.limits, self.missing = limits, missing

    def apart(self, x):
        """What the rig's own numbers cannot explain of x."""
        return x - self.N @ np.linalg.lstsq(self.N, x, rcond=None)[0]

    def scores(self, name="rig", dispersion=1.0, own=()):
        X = self.apart(self.X)
        variants = []
        for i, id in enumerate(EFFECTS):
            amplitudes = (("p", "N m"), ("q", "1"))[: 2 if id == "two" else 1]
            if id not in self.missing:
                variants.append(ScoredVariant(id, "spring", (), amplitudes, i, dispersion))
        V = X.T @ X
        return RigScores(
            name,
            tuple(variants),
            -X.T @ self.y,
            V,
            V,
            np.tile(self.limits, (6, 1)),
            tuple((id, ()) for id in own),
        )


def fleet(seed, n=8, shared=(0.0,) * 6, **how):
    rng = np.random.default_rng(seed)
    return [Rig(rng, shared, **how) for _ in range(n)]


def scores_of(rigs, **how):
    return [rig.scores(f"rig-{i + 1}", **how) for i, rig in enumerate(rigs)]
