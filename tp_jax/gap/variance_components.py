"""Shares of several sources in what is left unexplained: restricted maximum likelihood.

The coefficients of a source (`free_torques`) are random, independent from window to window, with
one variance for all of them; what is shared by all windows is fixed and unknown. Sources compete:
one that explains the residuals with smaller coefficients, or fewer, is the likelier, however well
another could do with large ones. Variances of zero are boundary values, and usual.

Source: Patterson, Thompson (1971), Biometrika 58, 545-554.
"""

import dataclasses
from collections.abc import Sequence

import numpy as np
from scipy.optimize import minimize

from tp_jax.estimation.elimination import Eliminated

LEAST, MOST = -8.0, 18.0  # of the logarithm of a variance, in units of what one window can tell
STARTS = (2.0, 8.0)
ENOUGH = {"ftol": 1e-6}  # of -2 log likelihood: a hundredth of it where sources differ by many


@dataclasses.dataclass(frozen=True)
class Components:
    """Some sources at their likeliest variances.

    logs: of the variances; gain: log-likelihood, less that without any source; by_window: (w,) the
    part of each window; coefficients: (w, q) means of all coefficients, zero for other sources;
    shared: (u,) how what all windows share moves with them.
    """

    sources: tuple[str, ...]
    logs: np.ndarray
    gain: float
    by_window: np.ndarray
    coefficients: np.ndarray
    shared: np.ndarray


class VarianceComponents:
    """The residuals of a fit, and the sources that may explain them.

    Args:
        left: gradients and information of the sources' coefficients, then of what is shared by
            all windows, the windows' states projected out.
        source: (q,) name of the source of each coefficient.
        weight: (q,) how large a coefficient is compared with others of its source, both in units
            of what the windows tell of it; all alike if None.
    """

    def __init__(self, left: Eliminated, source: np.ndarray, weight: np.ndarray | None = None):
        self.source = source
        self.names = tuple(str(n) for n in dict.fromkeys(source))
        size = np.sqrt(np.maximum(np.einsum("wii->i", left.H) / left.H.shape[0], 1e-300))
        if weight is not None:
            size[: source.size] /= weight
        self._size = size
        self._H = left.H / np.outer(size, size)
        self._g = left.g / size
        self._cost = left.cost
        q = source.size
        nobody = np.zeros((0, 0), dtype=bool)
        fixed = (self._H[:, q:, q:], self._g[:, q:])
        self._nothing = _Solved(np.zeros(0), nobody, *fixed, left.cost, 0).by_window

    def fit(self, names: Sequence[str], start: Sequence[float] | None = None) -> Components:
        """Some sources together, from logarithms of variances where they are nearly known."""
        q = self.source.size
        mine = np.flatnonzero(np.isin(self.source, names))
        member = np.array([self.source[mine] == n for n in names])
        rows = np.concatenate([mine, np.arange(q, self._g.shape[1])])
        H, g, k = self._H[:, rows][:, :, rows], self._g[:, rows], mine.size

        def objective(logs):
            at = _Solved(logs, member, H, g, self._cost, k)
            return at.value, at.slope

        limits = [(LEAST, MOST)] * len(names)
        tried = [
            minimize(objective, x, jac=True, method="L-BFGS-B", bounds=limits, options=ENOUGH)
            for x in ([np.full(len(names), x) for x in STARTS] if start is None else [start])
        ]
        best = min(tried, key=lambda found: found.fun)
        at = _Solved(best.x, member, H, g, self._cost, k)
        gains = 0.5 * (self._nothing - at.by_window)
        coefficients = np.zeros((H.shape[0], q))
        coefficients[:, mine] = -at.u / self._size[mine]
        shared = -at.move / self._size[q:]
        return Components(tuple(names), best.x, float(gains.sum()), gains, coefficients, shared)


class _Solved:
    """-2 restricted log-likelihood at some variances, and its slope by their logarithms.

    logs: (k,) of the variances; member: (k, q) whose each coefficient is; H, g, cost: as in
    `Eliminated`, the q coefficients first.
    """

    def __init__(self, logs, member, H, g, cost, q):
        root = np.exp(0.5 * (logs @ member)) if q else np.zeros(0)
        cc, cb, bb = H[:, :q, :q], H[:, :q, q:], H[:, q:, q:]
        gc, gb = g[:, :q], g[:, q:]
        inner = np.eye(q) + root[:, None] * cc * root
        right = root[:, None] * np.concatenate([gc[..., None], cb], axis=2)
        unit = np.broadcast_to(np.eye(q), inner.shape)
        solved = np.linalg.solve(inner, np.concatenate([right, unit], axis=2))
        inverse = solved[..., right.shape[2] :]
        # coefficients that follow the residuals, and what is shared
        follow = root[:, None] * solved[..., : right.shape[2]]
        Br_w = gb - np.einsum("wqb,wq->wb", cb, follow[..., 0])
        BB_w = bb - np.einsum("wqb,wqc->wbc", cb, follow[..., 1:])
        BB = BB_w.sum(axis=0)
        BB = BB + 1e-9 * np.trace(BB) / max(BB.shape[0], 1) * np.eye(BB.shape[0])
        move = np.linalg.solve(BB, Br_w.sum(axis=0))
        quad_w = cost - np.einsum("wq,wq->w", gc, follow[..., 0])
        quad_w = quad_w - 2.0 * Br_w @ move + np.einsum("b,wbc,c->w", move, BB_w, move)
        log_w = np.linalg.slogdet(inner)[1]
        shared = np.linalg.slogdet(BB)[1]
        self.by_window = quad_w + log_w + shared / cost.size
        self.value = float(self.by_window.sum())
        self.move = move
        self.u = u = follow[..., 0] - np.einsum("wqb,b->wq", follow[..., 1:], move)
        kept = 1.0 - np.einsum("wii->wi", inverse)
        covariance = np.linalg.inv(BB)
        through = np.einsum("wqb,bc,wqc->wq", follow[..., 1:], covariance, follow[..., 1:])
        variance = np.maximum(root**2, 1e-300)
        slope = kept.sum(axis=0) - (u**2).sum(axis=0) / variance - through.sum(axis=0) / variance
        self.slope = member @ slope


@dataclasses.dataclass(frozen=True)
class Attribution:
    """Shares of channels, largest first, with 95 % intervals from resampled windows.

    alone: of each channel, the likeliest of its sources.
    """

    channels: tuple[str, ...]
    shares: np.ndarray
    low: np.ndarray
    high: np.ndarray
    alone: dict[str, Components]


def attribute(
    parts: VarianceComponents, block: np.ndarray, seed: int = 0, draws: int = 500
) -> Attribution:
    """Shares of the channels in what all of them together gain.

    Of each channel the source counts that is likeliest alone. The likeliest of these has what it
    gains alone; the one that then adds most what it adds; the rest goes to the others in proportion
    to what each would add to these two.

    Args:
        parts: residuals and sources; the first word of a source's name is its channel.
        block: (w,) windows that are resampled together.
        seed: of the resampling.
    """
    alone: dict[str, Components] = {}
    for n in parts.names:
        channel, found = n.split()[0], parts.fit([n])
        if channel not in alone or found.gain > alone[channel].gain:
            alone[channel] = found
    first = max(alone, key=lambda c: alone[c].gain)
    others = [c for c in alone if c != first]

    def beside(before: Components, c: str) -> Components:
        return parts.fit([*before.sources, *alone[c].sources], [*before.logs, *alone[c].logs])

    steps = {first: alone[first].by_window}
    if others:
        with_first = {c: beside(alone[first], c) for c in others}
        second = max(others, key=lambda c: with_first[c].gain)
        both = with_first[second]
        steps[second] = both.by_window - alone[first].by_window
        for c in (c for c in others if c != second):
            steps[c] = beside(both, c).by_window - both.by_window
    gains = np.stack(list(steps.values()), axis=1)
    n_blocks = int(block.max()) + 1
    by_block = np.zeros((n_blocks, gains.shape[1]))
    np.add.at(by_block, block, gains)
    rng = np.random.default_rng(seed)
    counts = rng.multinomial(n_blocks, np.full(n_blocks, 1.0 / n_blocks), size=draws)

    def shares(total: np.ndarray) -> np.ndarray:
        total = np.maximum(total, 0.0)
        return total / np.maximum(total.sum(axis=-1, keepdims=True), 1e-300)

    low, high = np.quantile(shares(counts @ by_block), [0.025, 0.975], axis=0)
    value = shares(by_block.sum(axis=0))
    order = np.argsort(-value, kind="stable")
    names = list(steps)
    return Attribution(tuple(names[i] for i in order), value[order], low[order], high[order], alone)
