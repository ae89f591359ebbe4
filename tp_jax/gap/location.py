"""Place of the gap: shares of locations, and the component of the motion it goes with."""

import numpy as np

from tp_jax.effects import CHANNELS
from tp_jax.effects import get as get_effect
from tp_jax.estimation.blocks import blocks_of
from tp_jax.estimation.elimination import eliminate
from tp_jax.estimation.linearisation import Linearisation, spread
from tp_jax.estimation.parts import some_of
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.estimation.schedule import few_of
from tp_jax.gap.choice import Choice
from tp_jax.gap.free_torques import free_columns
from tp_jax.gap.policy import POLICY
from tp_jax.gap.refit import removable
from tp_jax.gap.variance_components import VarianceComponents, attribute
from tp_jax.results.diagnosis import Location

MOST_WINDOWS = 400
"""Windows that are asked where a gap lies: what is free in each has 300 numbers, all of them
correlated, and more windows say it no better."""

EXPLAINED = 0.9  # of the removable gap: causes that take so much say where it lies themselves


def locate(choice: Choice, setting: PreparedCampaign, seed: int = 0) -> list[Location]:
    """Shares by location, largest first; they sum to one.

    Causes that explain the gap, or leave no structure, say where it lies: each has what it took
    with it when it was added. Otherwise what is left free in every window does (`free_torques`),
    which needs no cause; within a channel it is the location of a cause, or else of the effect that
    would help most there.
    """
    total = max(removable(choice.rounds[0].searched), 1e-12)
    taken: dict[str, float] = {}
    when: dict[str, str] = {}
    for r in choice.rounds:
        if r.taken is None:
            continue
        location = get_effect(choice.standing_for(r.taken)).location
        drop = max(r.searched.cost - r.refits[r.taken].cost, 0.0)
        taken[location] = taken.get(location, 0.0) + drop
        when.setdefault(location, describe(r, location))
    last = [r.refits[r.taken].fit for r in choice.rounds if r.taken is not None][-1:]
    # Of a small gap the noise's own uncertainty is a large part; then no structure left will do.
    nothing_left = choice.structure.p >= POLICY.structure.seen
    if last and (removable(last[0]) <= (1.0 - EXPLAINED) * total or nothing_left):
        norm = sum(taken.values())
        ranked = sorted(taken.items(), key=lambda kv: -kv[1])
        return [Location(p, CHANNELS[p], v / norm, when[p], None) for p, v in ranked if v > 0.0]
    return _without_cause(choice, setting, taken, when, seed)


def _without_cause(choice, setting, taken, when, seed) -> list[Location]:
    fit = choice.rounds[0].before
    windows = fit.problem.windows.n
    if windows > MOST_WINDOWS:
        fit = some_of(fit, few_of(windows, MOST_WINDOWS))
    free = free_columns(setting, fit)
    base = [u for u, b in zip(fit.unknowns, fit.at_bound, strict=True) if not b]
    base_jac = spread(fit.linearisation, base)
    lin = fit.linearisation
    left = eliminate(lin.r, lin.states_jac, np.concatenate([free.jac, base_jac], axis=2))
    found = attribute(
        VarianceComponents(left, free.source, free.weight), blocks_of(fit, setting), seed
    )
    best: dict[str, tuple[float, str]] = {}
    for s in choice.rounds[0].screen.best():
        location = s.variant.effect.location
        # what was taken by a cause counts before what is only predicted
        score = taken.get(location, 0.0) * 1e6 + s.drop
        channel = CHANNELS[location]
        best[channel] = max(best.get(channel, (-1.0, "")), (score, location))
    shares = []
    for n, share, low, high in zip(
        found.channels, found.shares, found.low, found.high, strict=True
    ):
        if share <= 0.0:
            continue
        location = best.get(n, (0.0, n))[1]
        text = when.get(location)
        if text is None:
            alone = found.alone[n]
            both = np.concatenate(
                [alone.coefficients, np.broadcast_to(alone.shared, (lin.r.shape[0], len(base)))],
                axis=1,
            )
            states = left.state_step + np.einsum("wxu,wu->wx", left.state_gain, both)
            after = lin.r + np.einsum("wmx,wx->wm", lin.states_jac, states)
            after = after + np.einsum("wmu,wu->wm", free.jac, alone.coefficients)
            after = after + base_jac @ alone.shared
            text = densest(lin, after, location)
        interval = (float(min(low, share)), float(max(high, share)))
        shares.append(Location(location, n, float(share), text, interval))
    return shares


def describe(round_, location: str) -> str:
    """The part of the motion in which a cause lowers the squared residuals most densely."""
    return densest(
        round_.searched.linearisation, round_.refits[round_.taken].fit.linearisation.r, location
    )


def densest(before: Linearisation, after: np.ndarray, location: str) -> str:
    """The part of the motion in which squared residuals fall most densely.

    Args:
        before: a linearisation. after: (w, m) its residuals afterwards.
        location: which motion is looked at.
    """
    n = before.n_samples
    w = before.r.shape[0]
    shape = (w, n, 2)
    gone = (before.r[:, :-4].reshape(shape) ** 2 - after[:, :-4].reshape(shape) ** 2).sum(axis=2)
    valid = before.valid[:, :-4].reshape(shape).any(axis=2)
    y = before.states
    best, text = -np.inf, "throughout"
    for name, mask in _regimes(y, location):
        inside = mask & valid
        part = inside.sum() / max(valid.sum(), 1)
        if 0.02 < part < 0.9:
            share = gone[inside].sum() / max(gone[valid].sum(), 1e-12)
            # Densest regime that holds at least half of what is gone.
            score = share / part if share > 0.5 else -np.inf
            if score > best and score > 1.2:
                best, text = (
                    score,
                    f"{name} ({100 * share:.0f} % of it in {100 * part:.0f} % of the time)",
                )
    return text


def _regimes(y: np.ndarray, location: str):
    """Named parts of the motion: (name, mask (w, n))."""
    phi1, phi2, v1, v2 = (y[..., i] for i in range(4))
    slow = 0.02
    if location in ("contact", "sensor2", "clock"):
        yield "while the rider sticks", np.abs(v2) <= slow
        for limit in (0.3, 1.0, 3.0):
            yield f"sliding below {limit:g} rad/s", (np.abs(v2) > slow) & (np.abs(v2) <= limit)
            yield f"sliding above {limit:g} rad/s", np.abs(v2) > limit
        if location == "sensor2":
            for limit in (0.3, 0.7):
                yield f"where |phi2| exceeds {limit:g} rad", np.abs(phi2) > limit
    else:
        for limit in (0.5, 2.0):
            yield f"column below {limit:g} rad/s", np.abs(v1) <= limit
            yield f"column above {limit:g} rad/s", np.abs(v1) > limit
        for q in (0.5, 0.75):
            level = float(np.quantile(np.abs(phi1), q))
            yield f"where |phi1| exceeds {level:.2g} rad", np.abs(phi1) > level
            yield f"where |phi1| is below {level:.2g} rad", np.abs(phi1) <= level
