"""Plan of the cases of a trial: kinds in fixed proportion, effects by turns, in random order."""

import dataclasses
import itertools
from collections.abc import Iterator, Mapping

import numpy as np

from tp_jax.errors import InputError
from tp_jax.rig.effects import catalogue
from trials.effects.base import Outside, is_cousin

#: One effect of the catalogue, none at all, one from outside it, two of it.
PARTS = {"one": 200, "none": 120, "outside": 60, "two": 60}
#: The same on rough rigs, and one of a kind that the catalogue knows, by another formula.
ROUGH_PARTS = {"one": 120, "none": 90, "cousin": 90, "outside": 30, "two": 30}
RIGS = {"clean": PARTS, "rough": ROUGH_PARTS}


@dataclasses.dataclass(frozen=True)
class Case:
    """A case to be made.

    Attributes:
        name: of its folder.
        kind: one of `PARTS` or `ROUGH_PARTS`.
        seed: of all chance in it.
        preferred: effects to hide, those most wanted first; the first that a rig can show in
            their plausible size are taken, as many as the kind has.
    """

    name: str
    kind: str
    seed: int
    preferred: tuple[str, ...]

    @property
    def wanted(self) -> int:
        """Number of effects to be hidden."""
        return {"none": 0, "two": 2}.get(self.kind, 1)


def plan_cases(
    cases: int, seed: int, rigs: str = "clean", parts: Mapping[str, int] | None = None
) -> list[Case]:
    """The cases of a trial, the same for the same arguments.

    Args:
        cases: how many in all.
        seed: of the draw.
        rigs: one of `RIGS`.
        parts: how many of each kind, if not as `RIGS` has them.

    Raises:
        InputError: there are none, or no such rigs.
    """
    if rigs not in RIGS:
        raise InputError(f"Rigs are {' or '.join(RIGS)}, not {rigs!r}.")
    if cases < 1:
        raise InputError(f"A trial needs at least one case, not {cases}.")
    rough = rigs == "rough"
    # the two kinds of trials share no chance
    rng = np.random.default_rng([seed, 2 if rough else 0])
    kinds = [kind for kind, n in counts(cases, parts or RIGS[rigs]).items() for _ in range(n)]
    rng.shuffle(kinds)
    every = catalogue().values()
    inside = [e.id for e in every if e.in_catalogue]
    outside = [e.id for e in every if isinstance(e, Outside) and not e.rough_only]
    cousins = [e.id for e in every if is_cousin(e)]
    if rough:
        outside = [id for id in outside if id not in cousins]
    turns = {
        "one": _turns(inside, rng),
        "two": _turns(inside, rng),
        "outside": _turns(outside, rng),
        "cousin": _turns(cousins, rng),
    }
    width = max(3, len(str(cases)))
    plan = []
    for i, kind in enumerate(kinds):
        order = () if kind == "none" else next(turns[kind])
        case_seed = int(np.random.SeedSequence([seed, 3 if rough else 1, i]).generate_state(1)[0])
        plan.append(Case(f"case-{i + 1:0{width}d}", kind, case_seed, order))
    return plan


def counts(cases: int, parts: Mapping[str, int] = PARTS) -> dict[str, int]:
    """Cases of each kind, by largest remainders."""
    whole = sum(parts.values())
    exact = {kind: cases * part / whole for kind, part in parts.items()}
    out = {kind: int(x) for kind, x in exact.items()}
    by_rest = sorted(exact, key=lambda kind: out[kind] - exact[kind])
    for kind in by_rest[: cases - sum(out.values())]:
        out[kind] += 1
    return out


def _turns(ids: list[str], rng: np.random.Generator) -> Iterator[tuple[str, ...]]:
    """Every effect comes first once before one does again; the others follow at random."""
    for i in itertools.count():
        if i % len(ids) == 0:
            first = rng.permutation(ids).tolist()
        head = first[i % len(ids)]
        rest = [id for id in rng.permutation(ids).tolist() if id != head]
        yield (head, *rest)
