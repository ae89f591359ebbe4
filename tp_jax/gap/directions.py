"""The columns of an effect in a linearisation: its amplitudes, at one set of shape constants."""

import dataclasses
import itertools
from collections.abc import Sequence

from tp_jax.effects import Effect, Law
from tp_jax.effects.laws import HALF, MIDDLE
from tp_jax.estimation.layout import Unknown
from tp_jax.estimation.prepared_campaign import PreparedCampaign


@dataclasses.dataclass(frozen=True)
class Variant:
    """An effect with its shape constants fixed.

    Attributes:
        effect: the effect.
        shapes: constant to value.
        unknowns: its amplitudes, one per recording where they are.
    """

    effect: Effect
    shapes: tuple[tuple[str, float], ...]
    unknowns: tuple[Unknown, ...]

    @property
    def settings(self) -> dict[str, float]:
        """Slots of the shape constants to their values."""
        numbers = {**dict(self.shapes), **self.effect.constants}
        return {self.effect.qualified(n): v for n, v in numbers.items()}


def amplitude_unknowns(effect: Effect, setting: PreparedCampaign) -> tuple[Unknown, ...]:
    """The amplitudes of an effect over the fitted recordings."""
    unknowns: list[Unknown] = []
    for a in effect.amplitudes:
        name = effect.qualified(a.name)
        if not a.per_recording:
            unknowns.append(Unknown(name))
            continue
        for i in setting.fitted[:-1] if effect.relative else setting.fitted:
            r = setting.recordings[i]
            if "sine" in effect.needs and (not r.forced or r.measured_drive):
                continue
            unknowns.append(Unknown(name, i))
    return tuple(unknowns)


def variants(effect: Effect, setting: PreparedCampaign) -> list[Variant]:
    """The effect at every point of its shape grid; a law over what the recordings visit."""
    unknowns = amplitude_unknowns(effect, setting)
    if isinstance(effect, Law):
        middle, half = setting.supports[effect.id]
        return [Variant(effect, ((MIDDLE, middle), (HALF, half)), unknowns)]
    grids = [[(s.name, x) for x in s.grid] for s in effect.shapes]
    return [Variant(effect, tuple(c), unknowns) for c in itertools.product(*grids)]


def layers(all_variants: Sequence[Variant]) -> list[list[Variant]]:
    """Groups of variants in which every slot has one number: one linearisation each."""
    out: list[list[Variant]] = []
    seen: dict[str, int] = {}
    for v in all_variants:
        name = v.effect.slots or v.effect.id
        i = seen.get(name, 0)
        seen[name] = i + 1
        if i == len(out):
            out.append([])
        out[i].append(v)
    return out
