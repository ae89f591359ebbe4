"""Choice of the effects that each compiled program of a campaign carries."""

from collections.abc import Callable, Collection, Sequence

import numpy as np

from tp_jax.estimation.layout import Layout
from tp_jax.estimation.placement import Experience

NONE = frozenset[str]()


class Programs:
    """Compiled programs of a campaign, and the effects that each carries.

    A family of effects shares one, so that all of them may be looked at (`Layout.families`). In
    addition to effects that are there already, all families without states share one, which serves
    whatever is there, and is compiled once for all campaigns. One of everything would take minutes
    to compile and gigabytes: a family with states is looked at in addition to just what is there,
    and so are laws and an effect from outside the package. Each is compiled when it is first
    needed; what fits into several uses the smallest.
    """

    def __init__(self, layout: Layout):
        self.layout = layout
        self.experience = Experience()
        self.known = [NONE, *layout.families]
        self.moving = frozenset().union(*layout.families)
        self.apart = [
            f
            for f in layout.families
            if layout.n_states(f) > layout.n_states() or f & (layout.outside | layout.learned)
        ]
        self.plain = self.moving.difference(*self.apart)
        self.owner = {i: e.id for e in layout.effects for i in layout.amplitudes(frozenset({e.id}))}

    def active(self, p: np.ndarray) -> frozenset[str]:
        """Effects of the motion with an amplitude in p (P, ...)."""
        there = np.flatnonzero(p.any(axis=tuple(range(1, p.ndim)))).tolist()
        return frozenset(self.owner[i] for i in there if i in self.owner) & self.moving

    def asked(self, directions: Sequence[int]) -> frozenset[str]:
        """Effects of the motion with an amplitude among some slots."""
        return frozenset(self.owner[i] for i in directions if i in self.owner) & self.moving

    def covering(self, needed: frozenset[str]) -> frozenset[str] | None:
        """The smallest known program with all that is needed."""
        fitting = [k for k in self.known if needed <= k]
        return min(fitting, key=self._size) if fitting else None

    def cover(self, active: frozenset[str], asked: frozenset[str]) -> frozenset[str]:
        """A program for effects that are there and others that are asked for."""
        needed = active | asked
        found = self.covering(needed)
        if found is None:
            families = [f for f in self.apart if f & asked]
            found = active.union(*families) if families else self.plain | needed
            self.known.append(found)
        return found

    def add(self, ids: Collection[str]) -> None:
        """A program for these effects of the motion and no others."""
        exact = self.moving & frozenset(ids)
        if exact not in self.known:
            self.known.append(exact)

    def portions(
        self,
        slots: Sequence[int],
        active: frozenset[str],
        width: Callable[[frozenset[str], int], int],
    ) -> list[tuple[list[int], frozenset[str]]]:
        """Places in `slots` by call and the program of each.

        Effects of different families in calls of their own, unless a program has them all. What
        belongs to no effect of the motion fills up calls that have room.

        Args:
            slots: what is asked for.
            active: effects that are there.
            width: how many a call to a program takes that is asked for so many.
        """
        most = width(active, len(self.layout.parameters))
        new = self.asked(slots) - active
        kinds = [f for f in self.layout.families if f & new]
        if self.covering(active | new):
            kinds = [new] if new else []
        calls: list[list[int]] = []
        for kind in kinds:
            mine = [k for k, slot in enumerate(slots) if self.owner.get(slot) in kind]
            step = width(kind, 1)
            calls += [mine[i : i + step] for i in range(0, len(mine), step)]
        placed = {k for call in calls for k in call}
        rest = [k for k in range(len(slots)) if k not in placed]
        out = []
        for call in calls:
            ids = self.cover(active, self.asked([slots[k] for k in call]))
            # Where all goes into one program it is asked for all at once, as it will be from the
            # next iteration on: a narrow call alone would be compiled for a single use.
            alone = len(calls) == 1 and ids <= active | new
            room = width(ids, len(call) + len(rest) if alone else len(call)) - len(call)
            out.append((call + rest[:room], ids))
            rest = rest[room:]
        while rest or not out:
            out.append((rest[:most], self.cover(active, NONE)))
            rest = rest[most:]
        return out

    def _size(self, ids: frozenset[str]) -> tuple[int, int]:
        return self.layout.n_states(ids), len(ids)
