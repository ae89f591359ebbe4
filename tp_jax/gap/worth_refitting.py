"""Effects that are worth a refit in a round of the choice, in which order."""

from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.gap.earning import LIKELIER, PER_AMPLITUDE
from tp_jax.gap.policy import POLICY
from tp_jax.gap.refit import Refit
from tp_jax.gap.screen import Scored, Screen
from tp_jax.gap.structure import Structure

PAIR = 1.1  # times what the best effect promises: two that promise more are both refitted


def worth_refitting(setting: PreparedCampaign, seen: Screen, structure: Structure) -> list[Scored]:
    """The effects worth a refit, best first; one at least.

    Not those that could only help with the wrong sign, nor, of one run, those that drift within
    it: nothing says that another run would drift alike.
    A refit knows nothing of the calibration's error. Where that is known, an effect of a sensor
    must therefore stand out in the screen, which does, or it would be credited with that error.
    """
    ranked = seen.best()
    if any(r.calibration_error for r in setting.recordings):
        level = POLICY.structure.seen
        sure = {s.id for s, p in zip(seen.scored, structure.by_variant, strict=True) if p < level}
        ranked = [
            s for s in ranked if s.id in sure or not s.variant.effect.location.startswith("sensor")
        ]
    if len(setting.fitted) < 2:
        ranked = [s for s in ranked if not s.variant.effect.drifts] or ranked[:1]
    return [s for s in ranked if s.drop > 0.0] or ranked[:1]


def known_first(
    seen: Screen, ranked: list[Scored], current: Refit, known: Refit | None
) -> list[Scored]:
    """The effects to refit, a cause that was found before ahead of the others."""
    if known is None:
        return ranked
    new = [id for id in known.ids if id not in current.ids][:1]
    first = [s for s in seen.best() if s.id in new]
    return [*first, *(s for s in ranked if s.id not in new)]


def with_pair(seen: Screen, ranked: list[Scored]) -> list[Scored]:
    """The effects to refit, with those two that would help most together among them.

    Where together they promise clearly more than any one.
    """
    pair = seen.pair()
    if pair is None or not ranked:
        return ranked
    a, b, drop = pair
    amplitudes = len(a.variant.unknowns) + len(b.variant.unknowns)
    if drop < PAIR * ranked[0].drop + LIKELIER + PER_AMPLITUDE * amplitudes:
        return ranked
    return ranked + [s for s in (a, b) if s.id not in {x.id for x in ranked}]
