"""Where the gap lies: shares of locations, and the component of the motion it goes with."""

import dataclasses

import numpy as np

from tp_jax.effects import CHANNELS
from tp_jax.effects import get as get_effect
from tp_jax.gap.choice import Choice
from tp_jax.gap.refit import removable


@dataclasses.dataclass(frozen=True)
class Share:
    """Part of the removable sum of squares that belongs to a location."""

    location: str
    channel: str
    share: float
    when: str


def locate(choice: Choice) -> list[Share]:
    """Shares by location, largest first; they sum to one.

    With causes: what each took with it when it was added. What no cause explains, and everything
    where there is none, goes to the locations in proportion to the best predicted drop in each.
    """
    total = max(removable(choice.baseline), 1e-12)
    parts: dict[str, float] = {}
    when: dict[str, str] = {}
    for r in choice.rounds:
        if r.taken is None:
            continue
        location = get_effect(r.taken).location
        drop = max(r.before.cost - r.refits[r.taken].cost, 0.0)
        parts[location] = parts.get(location, 0.0) + drop
        when.setdefault(location, describe(r, location))
    left = max(total - sum(parts.values()), 0.0)
    last = choice.rounds[-1]
    if left > 0.05 * total or not parts:
        drops: dict[str, float] = {}
        for s in last.screen.best():
            place = s.variant.effect.location
            drops[place] = max(drops.get(place, 0.0), s.drop)
        sum_drops = sum(drops.values())
        for place, drop in drops.items():
            parts[place] = parts.get(place, 0.0) + left * drop / max(sum_drops, 1e-12)
            when.setdefault(place, "at no particular time or speed that was looked at")
    norm = sum(parts.values())
    ranked = sorted(parts.items(), key=lambda kv: -kv[1])
    return [Share(p, CHANNELS[p], v / norm, when[p]) for p, v in ranked if v > 0.0]


def describe(round_, location: str) -> str:
    """The part of the motion in which a cause lowers the squared residuals most densely."""
    before = round_.before.linearisation
    after = round_.refits[round_.taken].fit.linearisation
    n = before.n_samples
    w = before.r.shape[0]
    shape = (w, n, 2)
    gone = (before.r[:, :-4].reshape(shape) ** 2 - after.r[:, :-4].reshape(shape) ** 2).sum(axis=2)
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
