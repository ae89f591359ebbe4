"""Counts of fleets, as Markdown for docs/scale.md."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from scripts import _markdown as markdown
from scripts._ledger import entries
from scripts._shared_trial.draws import EFFECTS, MOST_TIED, NOTHING, OWN, Drawn, drawn_fleets
from scripts._shared_trial.draws import SEED as SEED_OF_DRAWS
from scripts._shared_trial.rigs import FLEETS, RIGS, file_of
from tp_jax.errors import InputError
from tp_jax.gap.policy import POLICY
from tp_jax.gap.shared.scores import RigScores, read
from tp_jax.gap.shared.selection import KIND, Shared, shared_effects


def counted(screens: Path, ledger: Path, version: str) -> str:
    """All counts.

    Args:
        screens: folder of the saved screens. ledger: of the rigs. version: of the lines that count.

    Raises:
        InputError: there are fewer screens than a fleet needs.
    """
    fleets = {
        fleet: [
            scores
            for rig in range(1, RIGS + 1)
            if (scores := read(file_of(screens, fleet, rig))) is not None
        ]
        for fleet in range(1, len(FLEETS) + 1)
    }
    whole = {fleet: rigs for fleet, rigs in fleets.items() if len(rigs) == RIGS}
    most = max(fleets.values(), key=len)
    if len(most) < POLICY.shared.rigs:
        raise InputError(
            f"{screens} has too few screens; `./scripts/shared_trial look --screens {screens}` "
            "makes them."
        )
    of = [each for each in entries(ledger) if each["version"] == version]
    # a rig whose screen was lost is looked at twice and counts once
    lines = list({(each["fleet"], each["rig"]): each for each in of}.values())
    drawn = drawn_fleets(most)
    return "\n\n".join(
        [
            f"Drawn from the screens of {len(most)} rigs:",
            _of_draws(drawn),
            f"Full fleets of {RIGS} rigs:",
            _of_fleets(whole, lines) if whole else "None is whole yet.",
            markdown.circumstances(SEED_OF_DRAWS),
        ]
    )


def share(said: Iterable[bool]) -> str:
    """`9 of 10, 0.90 (0.60-0.98)`, with Wilson's interval."""
    from trials import measures
    from trials.table import measure

    answers = list(said)
    return f"{sum(answers)} of {len(answers)}: {measure(measures.share(answers))}"


def _of_draws(drawn: Sequence[Drawn]) -> str:
    heads = (
        "the rigs share",
        "right",
        "named first as the kind's",
        "more named after it",
        "shown by a rig alone",
    )
    rows = []
    for effect in (NOTHING, OWN, *EFFECTS):
        mine = [each for each in drawn if each.effect == effect]
        if mine:
            more = sum(bool(each.more) for each in mine)
            shares = share(each.right for each in mine), _named(mine), more, share(_alone(mine))
            rows.append((_shared(effect), *shares))
    some = [each for each in drawn if each.effect not in (NOTHING, OWN)]
    more = sum(bool(each.more) for each in some)
    rows.append(("any effect", share(each.right for each in some), "", more, share(_alone(some))))
    return markdown.table(heads, rows)


def _shared(effect: str) -> str:
    return {NOTHING: NOTHING, OWN: f"nothing; {OWN}"}.get(effect, effect)


def _named(drawn: Sequence[Drawn]) -> str:
    firsts = [each.first for each in drawn]
    said = [f"`{id}` {firsts.count(id)}" for id in sorted(set(firsts) - {""})]
    return ", ".join(said) or "none"


def _alone(drawn: Sequence[Drawn]) -> list[bool]:
    return [i < each.alone for each in drawn for i in range(each.rigs)]


def _of_fleets(fleets: dict[int, list[RigScores]], lines: Sequence[dict[str, Any]]) -> str:
    heads = (
        "the rigs share",
        "size over a rig's detectable one",
        "named as the kind's",
        "as a rig's own",
        "shown by a rig alone",
    )
    rows = []
    for fleet, rigs in fleets.items():
        effect = FLEETS[fleet - 1] or ""
        mine = [each for each in lines if each["fleet"] == fleet]
        multiples = sorted(each["multiple"] for each in mine if each["multiple"] is not None)
        sizes = f"{multiples[0]:.2g} to {multiples[-1]:.2g}" if multiples else "–"
        found = shared_effects(rigs, SEED_OF_DRAWS)
        rows.append(
            (
                effect or NOTHING,
                sizes,
                _effects(found, kind=True),
                _effects(found, kind=False),
                share(_seen_alone(each, effect) for each in mine),
            )
        )
    return markdown.table(heads, rows)


def _effects(found: Shared, *, kind: bool) -> str:
    said = []
    for each in found.effects:
        if (each.verdict == KIND) == kind:
            tied = f" (not told from {', '.join(each.tied)})" if each.tied else ""
            said.append(f"`{each.pooled.key[0]}`{tied}")
    return ", ".join(said) or "none"


def _seen_alone(line: dict[str, Any], effect: str) -> bool:
    """True if a rig alone shows the effect (any, if it is ""), or one that is tied with it."""
    if line["structure_p"] >= POLICY.structure.seen:
        return False
    small = len(line["tied"]) < MOST_TIED
    return not effect or line["first"] == effect or (small and line["first"] in line["tied"])
