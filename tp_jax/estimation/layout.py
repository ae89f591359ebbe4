"""The numbers that a rig has: every parameter, nuisance and effect in one row of slots.

The batch engine gets all slots for every lane; which of them are unknown is data (`Unknowns`).
So one compiled program serves the baseline and every effect.
"""

import dataclasses
import functools
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tp_jax.effects import AnyLaw, Applied, Effect
from tp_jax.effects.base import HOOKS
from tp_jax.model.bearing import Bearing
from tp_jax.model.contact import Contact
from tp_jax.model.drive import LanewiseDrive
from tp_jax.model.inertia_units import scales
from tp_jax.model.parameters import BASE, NUISANCES, SETTINGS, Parameter
from tp_jax.model.pendulum import (
    AbstractTorsionPendulum,
    DoubleTorsionPendulum,
    SingleTorsionPendulum,
)
from tp_jax.model.sensors import Sensors
from tp_jax.model.spring import LinearSpring

#: Numbers that a recording fixes: commanded frequency, kind of drive, drift clock.
GIVEN = (
    Parameter("omega", "rad/s", 0.0, 1e3, scope="recording", description="commanded frequency"),
    Parameter("running", "1", 0.0, 1.0, scope="recording", description="1: the sine drive runs"),
    Parameter("metered", "1", 0.0, 1.0, scope="recording", description="1: measured drive"),
    Parameter("drift_middle", "s", -1e9, 1e9, scope="recording"),
    Parameter("drift_rate", "1/s", 0.0, 1e9, scope="recording"),
)

#: Hooks of what is read, and of what moves; the clock's are both.
SENSORS = frozenset({"sensor1", "sensor2", "clock"})
MOTION = frozenset(HOOKS) - {"sensor1", "sensor2"}


#: Slots to which the rows of a program's arrays are rounded up.
ROOM = 32


def is_from_outside(effect: Effect) -> bool:
    """True where an effect's class is not one of this package's."""
    return type(effect).__module__.split(".")[0] != __name__.split(".")[0]


def order(effect: Effect) -> int:
    """Sorts a layout's effects: the catalogue's, `AnyLaw`, those from outside the package."""
    return 2 if is_from_outside(effect) else int(isinstance(effect, AnyLaw))


@dataclasses.dataclass(frozen=True)
class Layout:
    """The slots of one kind of pendulum with a set of effects.

    Attributes:
        kind: "double" or "single".
        effects: the effects whose amplitudes have slots, sorted by `order`: those from outside the
            package are the last (`room`).
    """

    kind: str
    effects: tuple[Effect, ...]

    @functools.cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """One per slot."""
        slots = [*BASE, *SETTINGS, *NUISANCES, *GIVEN]
        for effect in self.effects:
            for a in effect.amplitudes:
                scope = "recording" if a.per_recording else "campaign"
                slots.append(
                    Parameter(
                        effect.qualified(a.name),
                        a.unit,
                        a.lower,
                        a.upper,
                        scope=scope,
                        typical=a.typical,
                        per_inertia=scales(a.unit),
                    )
                )
            for s in effect.shapes:
                slots.append(
                    Parameter(effect.qualified(s.name), s.unit, min(s.grid), max(s.grid), "log")
                )
        return tuple(slots)

    @functools.cached_property
    def index(self) -> dict[str, int]:
        """Name to slot."""
        return {p.name: i for i, p in enumerate(self.parameters)}

    @property
    def room(self) -> int:
        """Rows of the arrays that compiled programs take: one for each slot, and some to spare.

        So a user's own effect, whose slots come last, leaves the programs that do not carry it as
        they were, and they are found in the cache.
        """
        return -(-len(self.parameters) // ROOM) * ROOM

    @functools.cached_property
    def outside(self) -> frozenset[str]:
        """Effects from outside the package."""
        return frozenset(e.id for e in self.effects if is_from_outside(e))

    @functools.cached_property
    def learned(self) -> frozenset[str]:
        """The effect that stands for all laws, if it is there."""
        return frozenset(e.id for e in self.effects if isinstance(e, AnyLaw))

    def described(self, ids: frozenset[str]) -> str:
        """All that a program which carries some effects takes from those of the package.

        It is the same in every process. Effects from outside are left out: see
        `program.described`. Laws that are not carried change nothing.
        """
        named = [
            f"{type(e).__module__}.{type(e).__qualname__}{'*' if e.id in ids else ''}"
            for e in self.effects
            if e.id not in self.outside | self.learned
        ]
        curves = [self.numbers(e) for e in self.carried(ids & self.learned)]
        return f"{self.kind} {named} {self.room} {curves}"

    def carried(self, ids: frozenset[str]) -> tuple[Effect, ...]:
        """The effects of some ids."""
        return tuple(e for e in self.effects if e.id in ids)

    def amplitudes(self, ids: frozenset[str]) -> tuple[int, ...]:
        """Slots of the amplitudes of some effects."""
        return tuple(
            self.index[e.qualified(a.name)] for e in self.carried(ids) for a in e.amplitudes
        )

    def numbers(self, effect: Effect) -> tuple[int, ...]:
        """Slots of an effect's amplitudes and shapes."""
        names = (*effect.amplitudes, *effect.shapes)
        return tuple(self.index[effect.qualified(x.name)] for x in names)

    @functools.cached_property
    def estimable(self) -> tuple[int, ...]:
        """Slots that may be unknown: neither given, nor settings, nor shapes from a grid."""
        fixed = {p.name for p in (*SETTINGS, *GIVEN)} - {"reaction"}
        fixed |= {e.qualified(s.name) for e in self.effects for s in e.shapes if not s.continuous}
        return tuple(i for i, p in enumerate(self.parameters) if p.name not in fixed)

    @functools.cached_property
    def sensing(self) -> frozenset[str]:
        """Effects that change what is read, not what moves."""
        return frozenset(e.id for e in self.effects if e.hook in SENSORS)

    def sensed(self, ids: frozenset[str]) -> frozenset[str]:
        """Effects of the readings in a program that carries some effects."""
        return self.sensing | (ids & self.learned)

    def lateness(self, table: np.ndarray) -> np.ndarray:
        """Returns how much later than recorded a measured drive is to be read (R,) [s].

        Args:
            table: all numbers (slots, R).
        """
        late = [self.index[e.qualified(e.reads_later)] for e in self.effects if e.reads_later]
        return table[late].sum(axis=0)

    @functools.cached_property
    def families(self) -> tuple[frozenset[str], ...]:
        """Effects of the motion in groups: what they add to a step's cost is alike.

        Those without a state of their own, those with one, those with two; laws. Those from
        outside the package are alone, so that nobody compiles all others anew with them.
        """
        kinds: dict[tuple, set[str]] = {}
        for e in self.effects:
            if e.hook in MOTION:
                apart = e.id if e.id in self.outside else "law" if e.id in self.learned else ""
                kinds.setdefault((apart, e.n_states), set()).add(e.id)
        return tuple(frozenset(kinds[kind]) for kind in sorted(kinds))

    def n_states(self, ids: frozenset[str] = frozenset()) -> int:
        """Number of states of a model with some effects."""
        return 4 + sum(e.n_states for e in self.carried(ids))

    def depends(self, ids: frozenset[str]) -> tuple[int, ...]:
        """Slots on which a model with some effects depends."""
        others = [e for e in self.effects if e.id not in ids]
        names = {e.qualified(x.name) for e in others for x in (*e.amplitudes, *e.shapes)}
        return tuple(i for i, p in enumerate(self.parameters) if p.name not in names)

    def model(
        self, p: Sequence, piece=None, left=None, ids: frozenset[str] | None = None
    ) -> AbstractTorsionPendulum:
        """A pendulum whose fields are the slots' arrays.

        Args:
            p: one array per slot.
            piece, left: coefficients and left edge of a measured drive's piece.
            ids: of the effects to carry; all if None.
        """
        v = dict(zip(self.index, p, strict=True))
        zero = 0.0 * v["B1"]
        drive = LanewiseDrive(
            A=v["A"] * v["running"],
            omega=v["omega"],
            offset=v["phase"],
            gain=v["gain"] * v["metered"],
            # The rest position is what is read, whatever the zero: the two hardly correlate then.
            level=(v["level"] - v["zero1"]) * v["metered"],
            piece=[zero] * 4 if piece is None else piece,
            left=zero if left is None else left,
        )
        terms = tuple(
            Applied(e, {a.name: v[e.qualified(a.name)] for a in (*e.amplitudes, *e.shapes)})
            for e in self.effects
            if ids is None or e.id in ids
        )
        shared: dict[str, Any] = dict(
            drive=drive,
            spring=LinearSpring(v["k"], v["preload"]),
            bearing=Bearing(v["c1"], v["M1"], v["eps1"]),
            sensors=Sensors(v["zero1"], v["zero2"]),
            B1=v["B1"],
            terms=terms,
            drift=(v["drift_middle"], v["drift_rate"]),
        )
        if self.kind == "single":
            return SingleTorsionPendulum(**shared)
        contact = Contact(v["Tv"], v["Ts1"], v["Tst"], v["T0"], v["eps2"])
        return DoubleTorsionPendulum(**shared, contact=contact, B2=v["B2"], reaction=v["reaction"])


@dataclasses.dataclass(frozen=True)
class Unknown:
    """One number to estimate: a slot, and the recording it belongs to (None: all of them)."""

    name: str
    recording: int | None = None


class Values:
    """The numbers of a campaign: (slots, recordings), changed only by making another one."""

    def __init__(self, layout: Layout, table: np.ndarray):
        self.layout = layout
        self.table = table

    @classmethod
    def build(cls, layout: Layout, n_recordings: int, values: Mapping[str, object]) -> "Values":
        """Makes them from numbers by name, each one or one per recording; shapes start mid-grid."""
        table = np.zeros((len(layout.parameters), n_recordings))
        for effect in layout.effects:
            for s in effect.shapes:
                table[layout.index[effect.qualified(s.name)]] = s.grid[len(s.grid) // 2]
        for name, value in values.items():
            table[layout.index[name]] = np.asarray(value, dtype=float)
        return cls(layout, table)

    def get(self, name: str, recording: int | None = None) -> float:
        """One number."""
        return float(self.table[self.layout.index[name], recording or 0])

    def replace(self, changes: Mapping[str, object]) -> "Values":
        """A copy with some slots set, each to one number or one per recording."""
        table = self.table.copy()
        for name, value in changes.items():
            table[self.layout.index[name]] = np.asarray(value, dtype=float)
        return Values(self.layout, table)

    def pick(self, unknowns: Sequence[Unknown]) -> np.ndarray:
        """Values of the unknowns."""
        return np.array([self.get(u.name, u.recording) for u in unknowns])

    def put(self, unknowns: Sequence[Unknown], x: np.ndarray) -> "Values":
        """A copy with the unknowns set."""
        table = self.table.copy()
        for u, value in zip(unknowns, x, strict=True):
            row = self.layout.index[u.name]
            table[row, slice(None) if u.recording is None else u.recording] = value
        return Values(self.layout, table)

    def recordings(self, index: Sequence[int]) -> "Values":
        """The numbers of some of the recordings."""
        return Values(self.layout, self.table[:, list(index)])

    def to_dict(self) -> dict[str, float | list[float]]:
        """Returns the numbers by name; a list where the recordings differ."""
        out: dict[str, float | list[float]] = {}
        for p, row in zip(self.layout.parameters, self.table, strict=True):
            out[p.name] = [float(x) for x in row] if p.scope == "recording" else float(row[0])
        return out
