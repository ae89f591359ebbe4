"""Posterior of the unknowns by the No-U-Turn sampler (blackjax), on the windowed problem.

Beside intervals from a parabola or a profile it shows the shape of what is known: bananas of Ts1,
Tst and T0, tails towards what cannot be excluded. Several chains, started apart, say whether they
found the same.

Source: Hoffman, Gelman (2014), Journal of Machine Learning Research 15, 1593-1623.
"""

import dataclasses
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int

from tp_jax.errors import InputError
from tp_jax.estimation.baseline import Setting
from tp_jax.estimation.least_squares import Fit
from tp_jax.identifiability.windowed_density import WindowedDensity, windowed_density

DRAWS, WARMUP, CHAINS = 250, 100, 2
FIRST_STEP = 0.1  # times ten is where the adaptation looks first: about one standard deviation
ACCEPTANCE = 0.8
DOUBLINGS = 6

Progress = Callable[[str, float | None], None]


@dataclasses.dataclass(frozen=True)
class Posterior:
    """Draws from a posterior.

    Attributes:
        names: (u,) unknowns, nuisances included.
        samples: (chains, draws, u) [SI units].
        rhat: (u,) potential scale reduction; above 1.05 the chains disagree.
        ess: (u,) effective number of independent draws.
        divergences: of all draws after the warm-up.
        leapfrogs: (chains, draws) steps of each.
    """

    names: tuple[str, ...]
    samples: Float[np.ndarray, "c n u"]
    rhat: Float[np.ndarray, " u"]
    ess: Float[np.ndarray, " u"]
    divergences: int
    leapfrogs: Int[np.ndarray, "c n"]

    def of(self, name: str) -> Float[np.ndarray, " m"]:
        """All draws of one unknown (chains * draws,)."""
        return self.samples[..., self.names.index(name)].ravel()

    def to_dict(self) -> dict[str, Any]:
        """Means, standard deviations and intervals as plain numbers."""
        out: dict[str, Any] = {"divergences": self.divergences, "parameters": {}}
        out["chains"], out["draws"] = self.samples.shape[:2]
        for i, name in enumerate(self.names):
            x = self.of(name)
            out["parameters"][name] = {
                "mean": float(x.mean()),
                "sd": float(x.std(ddof=1)),
                "ci95": np.quantile(x, [0.025, 0.975]).tolist(),
                "rhat": float(self.rhat[i]),
                "ess": float(self.ess[i]),
            }
        return out


def posterior(
    fit: Fit,
    setting: Setting,
    *,
    draws: int = DRAWS,
    warmup: int = WARMUP,
    chains: int = CHAINS,
    seed: int = 0,
    progress: Progress | None = None,
) -> Posterior:
    """Draws from the posterior about a fit.

    Args:
        fit: in windows; the chains begin about it.
        setting: its campaign.
        draws: kept of each chain.
        warmup: steps of each chain before them, in which the step size is found.
        chains: how many, two or more.
        seed: of everything random.
        progress: called with a stage's name and the part of it that is done.

    Raises:
        InputError: blackjax is not installed, or too little was asked for.
    """
    blackjax = _blackjax()
    if chains < 2 or draws < 4 or warmup < 1:
        raise InputError(
            "A posterior needs two chains or more of four draws or more and a warm-up, but "
            f"{chains} of {draws} after {warmup} were asked for."
        )
    density = windowed_density(fit, setting)
    step = _step(blackjax, density)
    start = jax.jit(lambda z, data: blackjax.nuts.init(z, density.of(data)))
    keys = jax.random.split(jax.random.key(seed), chains)
    samples, leapfrogs, divergences = [], [], 0
    for c, key in enumerate(keys):
        own, key = jax.random.split(key)
        z0 = 0.5 * jax.random.normal(own, (len(density.names),))
        state = start(z0, density.data)
        size, adapt, final = _adaptation(blackjax)
        rows, counts = [], []
        for i in range(warmup + draws):
            key, own = jax.random.split(key)
            state, info = step(own, state, size(), density.data)
            if i < warmup:
                adapt(float(info.acceptance_rate))
                if i + 1 == warmup:
                    final()
            else:
                rows.append(np.asarray(state.position))
                counts.append(int(info.num_integration_steps))
                divergences += bool(info.is_divergent)
            if progress is not None:
                part = (c + (i + 1) / (warmup + draws)) / chains
                progress("posterior", part)
        samples.append(density.values(np.array(rows)))
        leapfrogs.append(counts)
    table = np.array(samples)
    rhat = np.asarray(blackjax.diagnostics.potential_scale_reduction(jnp.asarray(table)))
    ess = np.asarray(blackjax.diagnostics.effective_sample_size(jnp.asarray(table)))
    return Posterior(density.names, table, rhat, ess, divergences, np.array(leapfrogs))


def _blackjax() -> Any:
    try:
        import blackjax
        import blackjax.diagnostics
    except ModuleNotFoundError as missing:
        if (missing.name or "").split(".")[0] != "blackjax":
            raise
        raise InputError(
            "A posterior needs blackjax, which is not installed: pip install 'tp-jax[posterior]'."
        ) from missing
    return blackjax


def _step(blackjax: Any, density: WindowedDensity) -> Any:
    """(key, state, step size, data) -> state and what happened, compiled."""
    kernel = blackjax.nuts.build_kernel()
    white = jnp.ones(len(density.names))

    @jax.jit
    def step(key, state, size, data):
        return kernel(key, state, density.of(data), size, white, DOUBLINGS)

    return step


def _adaptation(blackjax: Any) -> tuple[Callable, Callable, Callable]:
    """The step size now, what learns from an acceptance rate, what ends the learning."""
    from blackjax.adaptation.step_size import dual_averaging_adaptation

    del blackjax
    begin, update, end = dual_averaging_adaptation(ACCEPTANCE)
    now = {"state": begin(FIRST_STEP), "size": None}

    def size() -> jax.Array:
        return jnp.exp(now["state"].log_step_size) if now["size"] is None else now["size"]

    def adapt(rate: float) -> None:
        now["state"] = update(now["state"], rate)

    def final() -> None:
        now["size"] = jnp.asarray(end(now["state"]))

    return size, adapt, final
