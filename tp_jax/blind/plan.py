"""Which cases a trial has: kinds in fixed proportion, effects by turns, in random order."""

import dataclasses
import itertools
from collections.abc import Iterator

import numpy as np

from tp_jax.errors import InputError
from tp_jax.rig.effects import catalogue

#: One effect of the catalogue, none at all, one from outside it, two of it.
PARTS = {"one": 200, "none": 120, "outside": 60, "two": 60}


@dataclasses.dataclass(frozen=True)
class Case:
    """A case to be made.

    Attributes:
        name: of its folder.
        kind: one of `PARTS`.
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
        """How many effects are to be hidden."""
        return {"none": 0, "two": 2}.get(self.kind, 1)


def plan_cases(cases: int, seed: int) -> list[Case]:
    """The cases of a trial, the same for the same arguments.

    Args:
        cases: how many in all.
        seed: of the draw.

    Raises:
        InputError: there are none.
    """
    if cases < 1:
        raise InputError(f"A trial needs at least one case, not {cases}.")
    rng = np.random.default_rng([seed, 0])
    kinds = [kind for kind, n in counts(cases).items() for _ in range(n)]
    rng.shuffle(kinds)
    inside = [e.id for e in catalogue().values() if e.in_catalogue]
    outside = [e.id for e in catalogue().values() if not e.in_catalogue]
    turns = {
        "one": _turns(inside, rng), "two": _turns(inside, rng), "outside": _turns(outside, rng),
    }  # fmt: skip
    width = max(3, len(str(cases)))
    plan = []
    for i, kind in enumerate(kinds):
        order = () if kind == "none" else next(turns[kind])
        case_seed = int(np.random.SeedSequence([seed, 1, i]).generate_state(1)[0])
        plan.append(Case(f"case-{i + 1:0{width}d}", kind, case_seed, order))
    return plan


def counts(cases: int) -> dict[str, int]:
    """Cases of each kind, by largest remainders."""
    whole = sum(PARTS.values())
    exact = {kind: cases * part / whole for kind, part in PARTS.items()}
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
