"""The estimation problem: recordings in windows, and their linearisation at given numbers."""

import dataclasses
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from tp_jax.estimation.layout import Layout, Values
from tp_jax.estimation.linearisation import Linearisation
from tp_jax.estimation.packing import LANES, Packed, Rows, packed, packed_pieces, rows, steps_of
from tp_jax.estimation.placement import longest, place
from tp_jax.estimation.program import Linearised, linearise, remember
from tp_jax.estimation.program_choice import NONE, Programs
from tp_jax.estimation.two_threads import by_two
from tp_jax.estimation.windows import Prepared, Windows, read_later
from tp_jax.simulation.lanes import Tolerances

DIRECTIONS = 14  # directions in a call
FEW = 4  # directions in a call that asks for no more
WORTH = 0.95  # of the time, from which on windows are placed anew
_SIZES = (1024, 2048, 4096)


def sample_capacity(counts: Sequence[int]) -> int:
    """Samples a lane must hold for windows of these counts; one of a few sizes."""
    most = max(counts)
    return next((s for s in _SIZES if s >= most), most)


def room(windows: Windows, least: int) -> int:
    """Samples a lane must hold for these windows: `least`, or more where one of them is longer."""
    return max(least, sample_capacity(windows.count.tolist()))


@dataclasses.dataclass(frozen=True)
class Problem:
    """Recordings cut into windows, ready to be linearised.

    Attributes:
        layout: slots of the model.
        prepared: the recordings.
        windows: how they are cut.
        capacity: samples of a block; the same for all horizons of a campaign, so that one
            compiled program serves them.
        B1: inertia of the column, to which bounds and typical sizes are scaled [kg m^2].
        tolerances: of the integration.
        programs: which program carries which effects; its own if None.
    """

    layout: Layout
    prepared: tuple[Prepared, ...]
    windows: Windows
    capacity: int
    B1: float
    tolerances: Tolerances = Tolerances()  # noqa: RUF009
    programs: Programs = None  # type: ignore[assignment]

    def __post_init__(self):
        if self.programs is None:
            object.__setattr__(self, "programs", Programs(self.layout))

    def at(self, tolerances: Tolerances) -> "Problem":
        """The same windows integrated with other tolerances, by the same programs."""
        if tolerances == self.tolerances:
            return self
        other = dataclasses.replace(self, tolerances=tolerances)
        if "_cached_blocks" in self.__dict__:
            object.__setattr__(other, "_cached_blocks", self.blocks())
        return other

    @property
    def sigma(self) -> np.ndarray:
        """Noise (w, 2) of both channels in every window [rad]."""
        return np.array([self.prepared[r].sigma for r in self.windows.recording]).reshape(-1, 2)

    @property
    def measured(self) -> bool:
        """True where a drive was measured: the blocks then carry its pieces."""
        return any(p.pieces is not None for p in self.prepared)

    def initial_states(self, values: Values | None = None) -> np.ndarray:
        """Smoothed readings at the windows' starts, less the zeros of the angles (w, 4)."""
        w = self.windows
        rows = zip(w.recording, w.first, strict=True)
        states = np.array([self.prepared[r].smooth[f] for r, f in rows])
        if values is not None:
            for c, name in enumerate(("zero1", "zero2")):
                states[:, c] -= values.table[self.layout.index[name], w.recording]
        return states

    def own_states(self, values: Values, ids: frozenset[str]) -> np.ndarray:
        """Own states (w, k) of some effects at the windows' starts, from the motion until there."""
        count = self.layout.n_states(ids) - 4
        if not count:
            return np.zeros((self.windows.n, 0))
        past = remember(self.layout, ids, values.table, *self._paths(values))
        return np.asarray(past)[self.windows.recording, :, self.windows.first]

    def _paths(self, values: Values) -> tuple:
        """Times (R, n), motions (R, 4, n) and pieces of a measured drive of all recordings.

        Those that are shorter stay at their end.
        """
        n = max(p.t.size for p in self.prepared)
        t = np.stack([np.pad(p.t, (0, n - p.t.size), "edge") for p in self.prepared])
        y = np.stack([np.pad(p.path.T, ((0, 0), (0, n - p.t.size)), "edge") for p in self.prepared])
        for c, name in enumerate(("zero1", "zero2")):
            y[:, c] -= values.table[self.layout.index[name], :, None]
        if not self.measured:
            return t, y, None
        pieces = np.zeros((len(self.prepared), n, 4))
        for r, (p, read) in enumerate(zip(self.prepared, self._drives(values), strict=True)):
            if read is not None:
                pieces[r, : p.t.size - 1] = read
                pieces[r, p.t.size - 1 :] = read[-1]
        return t, y, pieces

    def _drives(self, values: Values) -> list[np.ndarray | None]:
        """Pieces of all recordings' measured drives, read as late as the values have it."""
        late = self.layout.lateness(values.table)
        return [
            None if p.pieces is None else read_later(p.t, p.pieces, float(x))
            for p, x in zip(self.prepared, late, strict=True)
        ]

    def degrees_of_freedom(self, unknowns: int) -> int:
        """Samples less estimated window states and unknowns.

        A window of one sample (an island between two gaps) has nothing left over, not less.
        """
        left = sum(
            max(c - 2, 0) * self.prepared[r].channels.sum()
            for r, c in zip(self.windows.recording, self.windows.count, strict=True)
        )
        return int(left - unknowns)

    def select(self, recordings: Sequence[int]) -> np.ndarray:
        """Windows (bool) of some recordings."""
        return np.isin(self.windows.recording, list(recordings))

    def _places(self) -> np.ndarray:
        """Returns the place of every window (w, 4), see `place`."""
        cost = self.programs.experience.expected(self.windows, self.prepared)
        return place(self.windows, cost, self.capacity, LANES)

    def _packed(self, places: np.ndarray) -> list[Packed]:
        found = []
        for b in range(int(places[:, 0].max()) + 1):
            which = np.flatnonzero(places[:, 0] == b)
            found.append(packed(self.prepared, self.windows, which, places[which], self.capacity))
        return found

    def blocks(self) -> list[Packed]:
        """Windows, their places (w, 4) and the data of all blocks; kept until they lie badly."""
        cached = self.__dict__.get("_cached_blocks")
        if cached is None:
            cached = self._packed(self._places())
            object.__setattr__(self, "_cached_blocks", cached)
        return cached

    def _rows(self) -> list[Rows]:
        """Samples of all blocks' windows."""
        blocks, cached = self.blocks(), self.__dict__.get("_cached_rows")
        if cached is None or cached[0] is not blocks:
            found = [rows(self.windows, each) for each in blocks]
            cached = blocks, found
            object.__setattr__(self, "_cached_rows", cached)
        return cached[1]

    def _learn(self, results: Sequence[Linearised]) -> None:
        """Takes note of the steps that windows took, and places them anew where that pays.

        Looked at after the second linearisation, the fourth and so on: most problems are of the few
        windows whose states are put right, and are linearised once.
        """
        times = self.__dict__.get("_times", 0) + 1
        object.__setattr__(self, "_times", times)
        if times & (times - 1):  # no power of two
            return
        blocks, steps = self.blocks(), np.zeros(self.windows.n)
        places = np.zeros((self.windows.n, 4), dtype=int)
        for (which, mine, _), out in zip(blocks, results, strict=True):
            places[which], steps[which] = mine, steps_of(out, self.windows, which, mine)
        self.programs.experience.learn(self.windows, steps)
        if times == 1:
            return
        new = place(self.windows, steps, self.capacity, LANES)
        if len(blocks) > new[:, 0].max() and longest(new, steps) < WORTH * longest(places, steps):
            object.__setattr__(self, "_cached_blocks", self._packed(new))

    def follow(
        self, values: Values, recordings: Sequence[int], states: np.ndarray
    ) -> list[np.ndarray]:
        """Readings (n, 2) [rad] of whole recordings that run freely, never corrected.

        Taken piece by piece by the program that fits windows. What an effect remembers begins at
        rest. What cannot be integrated is NaN.

        Args:
            values: all numbers.
            recordings: which.
            states: (r, 4) at their first samples.
        """
        n = [self.prepared[r].t.size for r in recordings]
        out = [np.full((size, 2), np.nan) for size in n]
        ids = self.programs.cover(self.programs.active(values.table), NONE)
        own = np.zeros((len(n), self.layout.n_states(ids) - 4))
        going, states = list(range(len(n))), np.array(states, dtype=float)
        for first in range(0, max(n) - 1, self.capacity - 1):
            going = [i for i in going if first < n[i] - 1]
            if not going:
                break
            count = [min(self.capacity, n[i] - first) for i in going]
            windows = Windows(
                np.array([recordings[i] for i in going]),
                np.full(len(going), first),
                np.array(count),
                self.windows.horizon,
            )
            part = dataclasses.replace(self, windows=windows)
            lin = part.linearise(values, states[going], (), own=own[going])
            assert lin.own is not None
            for k, (i, c) in enumerate(zip(going, count, strict=True)):
                p = self.prepared[recordings[i]]
                span = slice(first, first + c)
                error = lin.samples[k, : 2 * c].reshape(c, 2) * p.sigma
                out[i][span] = np.where(p.channels, p.y[span] + error, lin.states[k, :c, :2])
                states[i], own[i] = lin.states[k, c - 1], lin.own[k]
                if not lin.complete[k]:
                    out[i][first:] = np.nan
            going = [i for k, i in enumerate(going) if lin.complete[k]]
        return out

    def linearise(
        self,
        values: Values,
        states: np.ndarray,
        slots: Sequence[str],
        own: np.ndarray | None = None,
    ) -> Linearisation:
        """Residuals and derivatives of all windows.

        Args:
            values: all numbers.
            states: (w, 4) initial states of the windows.
            slots: names to differentiate by in addition to the states; any number, taken in
                fixed portions, and none in a program of its own.
            own: (w, k) the effects' own states there; from the motion until there if None.
        """
        index = [self.layout.index[s] for s in slots]
        active = self.programs.active(values.table)
        portions = self.programs.portions(index, active, self._width)
        spare = self.layout.index["reaction"]
        late = self.measured and np.any(self.layout.lateness(values.table))
        drives = self._drives(values) if late else []
        past = {ids: self.own_states(values, ids) if own is None else own for _, ids in portions}

        blocks = self.blocks()

        def run(job: tuple[int, int]) -> Linearised:
            which, places, block = blocks[job[0]]
            part, ids = portions[job[1]]
            if late:
                pieces = packed_pieces(drives, self.windows, which, places, self.capacity)
                block = block._replace(pieces=pieces)
            _, lane, at, _ = places.T
            p = np.repeat(values.table[:, :1], LANES, axis=1)
            p[:, lane] = values.table[:, self.windows.recording[which]]
            x0 = np.zeros((self.capacity, self.layout.n_states(ids), LANES))
            x0[at, :4, lane] = states[which]
            x0[at, 4:, lane] = past[ids][which]
            directions = [index[k] for k in part]
            directions += [spare] * (self._width(ids, len(part)) - len(part))
            out = linearise(
                self.layout,
                self.tolerances,
                ids,
                p,
                x0,
                block,
                np.array(directions, dtype=int),
            )
            return Linearised(*map(np.asarray, out))

        # neighbours are of different programs, so that two of them are compiled at once
        jobs = [(b, d) for b in range(len(blocks)) for d in range(len(portions))]
        results = dict(zip(jobs, by_two(run, jobs), strict=True))
        found = self._assemble(results, tuple(slots), [part for part, _ in portions])
        self._learn([results[b, 0] for b in range(len(blocks))])
        return found

    def _width(self, ids: frozenset[str], asked: int) -> int:
        """Directions of a call to a program that is asked for so many.

        Most of what is asked of effects with states of their own is one amplitude at many shapes.
        A call that asks for nothing takes a quarter of the time. The model without effects is
        seldom asked for few: a width of its own would be compiled for four calls of a diagnosis.
        """
        if not asked:
            return 0
        few = self.layout.n_states(ids) > 4 or 0 < len(self.layout.amplitudes(ids)) <= FEW
        return FEW if few and asked <= FEW else DIRECTIONS

    def compile_ahead(self, active: frozenset[str], states: bool = True) -> None:
        """Has the programs compiled, in threads of their own, that look at every effect.

        And those that settle windows: with what is there, and with what may come of it. Those of
        laws are the largest and most campaigns never ask for one: they wait until one does.

        Args:
            active: effects that have amplitudes.
            states: whether effects with states of their own are to be looked at too.
        """
        catalogued = [f for f in self.layout.families if not f & self.layout.learned]
        families = [f for f in catalogued if states or f <= self.programs.plain]
        programs = dict.fromkeys(self.programs.cover(active, family) for family in families)
        settling = self.programs.cover(active, NONE)
        plain = self.programs.cover(active, self.programs.plain)
        refits = [(plain, 0)] if states and plain != settling else []
        spare = self.layout.index["reaction"]

        def run(ids: frozenset[str], asked: int) -> None:
            nothing = np.zeros((0, 0), dtype=int)
            where = nothing.reshape(0, 4)
            block = packed(self.prepared, self.windows, nothing.ravel(), where, self.capacity).block
            linearise(
                self.layout,
                self.tolerances,
                ids,
                np.ones((len(self.layout.parameters), LANES)),
                np.zeros((self.capacity, self.layout.n_states(ids), LANES)),
                block,
                np.array([spare] * self._width(ids, asked), dtype=int),
            )

        pool = ThreadPoolExecutor(2)
        for ids, asked in ((settling, 0), *((ids, 1) for ids in programs), *refits):
            pool.submit(run, ids, asked)
        pool.shutdown(wait=False)

    def _assemble(
        self, results: dict, slots: tuple[str, ...], portions: list[list[int]]
    ) -> Linearisation:
        nw, n, nc = self.windows.n, int(self.windows.count.max()), 4
        m = 2 * n + 4
        r = np.zeros((nw, m))
        states_jac = np.zeros((nw, m, 4))
        slots_jac = np.zeros((nw, m, len(slots)))
        states = np.zeros((nw, n, nc))
        complete = np.zeros(nw, dtype=bool)
        valid = np.zeros((nw, m), dtype=bool)
        own = None if slots else np.zeros((nw, results[0, 0].own.shape[2]))
        # rows of both channels in one, for then a sample is one piece of memory
        by_sample, by_states, by_slots, seen = (
            a.reshape(nw * (n + 2), 2, *a.shape[2:]) for a in (r, states_jac, slots_jac, valid)
        )
        order = [k for part in portions for k in part]
        begin = np.cumsum([0, *map(len, portions)])
        where, channels = self._rows(), np.array([p.channels for p in self.prepared])
        for (b, d), out in results.items():
            which, places, _ = self.blocks()[b]
            source, window, row = where[b]
            to = window * (n + 2) + row
            _, lanes, at, rank = places.T
            jac = out.jac.reshape(-1, *out.jac.shape[2:]).take(source, axis=0)
            prior = out.prior_jac[lanes, rank]
            mine, end = slice(begin[d], begin[d + 1]), nc + len(portions[d])
            by_slots[to, :, mine] = jac[..., nc:end]
            slots_jac[which, -4:, mine] = prior[..., nc:end]
            if d:
                continue
            by_sample[to] = out.r.reshape(-1, 2).take(source, axis=0)
            by_states[to] = jac[..., :nc]
            r[which, -4:], states_jac[which, -4:] = out.prior_r[lanes, rank], prior[..., :nc]
            states[window, row] = out.states.reshape(-1, nc).take(source, axis=0)
            seen[to] = channels[self.windows.recording[window]]
            complete[which] = out.complete[lanes]
            if own is not None:
                own[which] = out.own[lanes, at + self.windows.count[which] - 1]
        if order != sorted(order):
            slots_jac = slots_jac[:, :, np.argsort(order)]
        for a in (r, states_jac, slots_jac):  # what is not finite must not spoil the rest
            a[~complete] = 0.0
        raw = None
        if self.coloured:
            raw = r[:, :-4].copy()
            for a in (r[:, :, None], states_jac, slots_jac):
                self.whiten(a)
        return Linearisation(
            r,
            states_jac,
            slots_jac,
            valid,
            states,
            complete,
            slots,
            self.windows.recording,
            own,
            raw,
        )

    @property
    def coloured(self) -> bool:
        """True where any sensor's noise is correlated from sample to sample."""
        return any(not c.is_white for p in self.prepared for c in p.colour)

    def whiten(self, columns: np.ndarray) -> None:
        """Takes the noise's correlation out of columns (w, m, q), rows as in `Linearisation`.

        In place. A window's first sample is taken as the first of all: what noise has in common
        over the edge of two windows is left out, as it is of their states.
        """
        n = (columns.shape[1] - 4) // 2
        rows = np.arange(n)[None, :] < self.windows.count[:, None]
        for c in range(2):
            kinds = [self.prepared[r].colour[c] for r in self.windows.recording]
            for kind in {k for k in kinds if not k.is_white}:
                mine = np.array([k == kind for k in kinds])
                which = slice(None) if mine.all() else mine  # a slice copies nothing
                white = kind.whiten(columns[which, c : 2 * n : 2], axis=1)
                columns[which, c : 2 * n : 2] = white * rows[which, :, None]
