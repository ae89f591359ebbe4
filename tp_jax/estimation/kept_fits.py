"""Fits that a diagnosis has done, kept in a file, from which one that was broken off goes on.

A diagnosis is a chain of fits: the same numbers go in, the same come out. So a fit is known by a
digest of all that goes in, and where its end is in the file, it is looked up instead of searched:
one linearisation in place of some twenty. `taken_or_done` is the one place where that happens; it
wraps the two functions that fit. What is looked up is used only if that linearisation is, bit for
bit, the one that the search ended with; so a result never depends on where a run was broken off.
Without a file they are kept in memory: a choice that comes by the same fit again need not search.
"""

import base64
import dataclasses
import functools
import hashlib
import logging
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any

import numpy as np

from tp_jax._stored import source_digest
from tp_jax._version import __version__
from tp_jax.errors import InputError
from tp_jax.estimation.checkpoint import FITS, Checkpoint
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.layout import Unknown, Values
from tp_jax.estimation.problem import Problem
from tp_jax.recordings import Campaign

log = logging.getLogger(__name__)

WRITE_EVERY = 3.0
"""Seconds between two writes: so much is lost at the most, and a file of megabytes is not written
for each of a hundred fits that take a tenth of a second."""

Fitter = Callable[..., Fit]


class InMemory:
    """A checkpoint without a file."""

    path = "memory"

    def __init__(self) -> None:
        self.done: dict[str, Any] = {}

    def put(self, results: Mapping[str, Any]) -> None:
        """Adds results."""
        self.done.update(results)


class KeptFits:
    """The fits of one diagnosis, in a checkpoint."""

    def __init__(
        self, checkpoint: Checkpoint | InMemory, now: Callable[[], float] = time.monotonic
    ):
        self.checkpoint = checkpoint
        self.taken = 0
        self._now, self._written, self._new = now, -np.inf, {}
        self._refused = False

    def begin(self) -> None:
        """Writes the file, so that there is something to resume from the first moment.

        Raises:
            OSError: it cannot be written.
        """
        self.checkpoint.put({})

    def write(self, *, at_once: bool = True) -> None:
        """Writes what is new, if it is time to or must be at once.

        A disk that is full by now ends the keeping, not the work: the result may be written where
        there is room.
        """
        if self._refused or not (at_once or self._now() - self._written >= WRITE_EVERY):
            return
        try:
            self.checkpoint.put(self._new)
        except OSError as fault:
            self._refused = True
            log.warning("fits are not kept any more: %s", fault)
        self._new, self._written = {}, self._now()

    def fit(
        self,
        fitter: Fitter,
        problem: Problem,
        values: Values,
        unknowns: Sequence[Unknown],
        states: np.ndarray | None,
        options: Mapping[str, Any],
    ) -> Fit:
        """The fit, looked up where it was kept, done and kept otherwise."""
        name = _digest(fitter, problem, values, unknowns, states, options)
        known = self.checkpoint.done.get(name) or self._new.get(name)
        if known is not None:
            found = _restored(known, fitter, problem, values, unknowns, options)
            if found is not None:
                self.taken += 1
                return found
            log.info("a kept fit does not end where it did, and is done anew")
        before = len(problem.programs.known)
        found = fitter(problem, values, unknowns, states, **options)
        self._new[name] = _record(found, problem.programs.known[before:])
        self.write(at_once=False)
        return found


_current: ContextVar[KeptFits | None] = ContextVar("fits that are kept", default=None)


@contextmanager
def keeping(checkpoint: Checkpoint | None) -> Iterator[None]:
    """Within the block fits are looked up in a checkpoint and kept there; None: in memory.

    What was done is written when the block ends, however it does.
    """
    kept = KeptFits(checkpoint or InMemory())
    kept.begin()
    token = _current.set(kept)
    try:
        yield
    finally:
        _current.reset(token)
        kept.write()
        log.info("%d fits were taken from %s", kept.taken, kept.checkpoint.path)


def taken_or_done(fitter: Fitter) -> Fitter:
    """The fitter, which looks a fit up where fits are kept."""

    @functools.wraps(fitter)
    def fit(
        problem: Problem,
        values: Values,
        unknowns: Sequence[Unknown],
        states: np.ndarray | None = None,
        **options: Any,
    ) -> Fit:
        kept = _current.get()
        if kept is None:
            return fitter(problem, values, unknowns, states, **options)
        return kept.fit(fitter, problem, values, unknowns, states, options)

    return fit


def fits_checkpoint(
    path: str | Path | None, resume: bool, campaign: Campaign, options: Mapping[str, Any]
) -> Checkpoint | None:
    """Opens the checkpoint of the fits of a diagnosis; to resume, reads those that are there.

    Args:
        path: the file; None: they are not kept.
        resume: whether to go on from it.
        campaign: with its recordings as they are used, held-out ones marked.
        options: of the diagnosis.

    Raises:
        InputError: there is nothing to resume, or it is of another diagnosis.
    """
    if path is None:
        if resume:
            raise InputError("To resume, the file with the finished fits must be named.")
        return None
    key = {
        "recordings": {r.label: _of_fields(r, but=("file",)) for r in campaign.recordings},
        "rig": _of_fields(campaign, but=("recordings", "folder")),
        "version": __version__,
        "source": source_digest(),
        **options,
    }
    kept = Checkpoint(Path(path), key, FITS)
    if resume:
        kept.resume()
    return kept


def _of_fields(of: Any, but: Sequence[str]) -> str:
    """SHA-256 of a dataclass's fields."""
    digest = hashlib.sha256()
    for field in dataclasses.fields(of):
        if field.name not in but:
            _feed(digest, (field.name, getattr(of, field.name)))
    return digest.hexdigest()


def _feed(digest: Any, value: Any) -> None:
    """Feeds a value to a digest, arrays by every bit, wherever they are in it."""
    if isinstance(value, np.ndarray):
        digest.update(f"{value.dtype}{value.shape}".encode() + value.tobytes())
    elif isinstance(value, list | tuple):
        digest.update(f"({len(value)}".encode())
        for each in value:
            _feed(digest, each)
    elif isinstance(value, Mapping):
        _feed(digest, sorted(value.items()))
    elif dataclasses.is_dataclass(value):
        names = [field.name for field in dataclasses.fields(value)]
        _feed(digest, [(name, getattr(value, name)) for name in names])
    else:
        digest.update(f"{value!r};".encode())


def _digest(
    fitter: Fitter,
    problem: Problem,
    values: Values,
    unknowns: Sequence[Unknown],
    states: np.ndarray | None,
    options: Mapping[str, Any],
) -> str:
    """SHA-256 of all that goes into a fit, but for the recordings, which the file's key names."""
    w = problem.windows
    noise = [(p.t.size, p.sigma.tolist(), p.channels.tolist(), p.colour) for p in problem.prepared]
    said = (
        fitter.__module__,
        problem.tolerances,
        problem.B1,
        problem.capacity,
        w.horizon,
        noise,
        list(unknowns),
        sorted((options.get("bounds") or {}).items()),
        sorted((name, value) for name, value in options.items() if name != "bounds"),
    )
    digest = hashlib.sha256(repr(said).encode())
    drives = [p.pieces for p in problem.prepared]  # noisy ones are put right between fits
    for array in (w.recording, w.first, w.count, values.table, states, *drives):
        digest.update(b"none" if array is None else np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def _record(found: Fit, programs: Sequence[frozenset[str]]) -> dict[str, Any]:
    """A fit's end as JSON can hold it; programs: those that it was the first to need."""
    return {
        "x": _packed(found.values.pick(found.unknowns)),
        "states": _packed(found.states),
        "cost": float(found.cost).hex(),
        "message": found.message,
        "evaluations": found.evaluations,
        "converged": bool(found.converged),
        "programs": [sorted(ids) for ids in programs],
        "ends_at": _ends_at(found),
    }


def _restored(
    record: Mapping[str, Any],
    fitter: Fitter,
    problem: Problem,
    values: Values,
    unknowns: Sequence[Unknown],
    options: Mapping[str, Any],
) -> Fit | None:
    """The fit of a record; None where it is not what the fit ended with."""
    x, states = _unpacked(record["x"]), _unpacked(record["states"])
    if x.size != len(unknowns) or states.size != 4 * problem.windows.n:
        return None
    for ids in map(frozenset, record["programs"]):
        if ids not in problem.programs.known:
            problem.programs.known.append(ids)
    there = {**options, "max_iterations": 0}  # the fitter's own way to where a fit is
    found = fitter(problem, values.put(unknowns, x), unknowns, states.reshape(-1, 4), **there)
    if float(found.cost).hex() != record["cost"] or _ends_at(found) != record["ends_at"]:
        return None
    return dataclasses.replace(
        found,
        converged=record["converged"],
        evaluations=record["evaluations"],
        message=record["message"],
    )


def _ends_at(found: Fit) -> str:
    """SHA-256 of the linearisation where a fit ended."""
    digest = hashlib.sha256(np.ascontiguousarray(found.linearisation.r).tobytes())
    for array in (found.eliminated.g, found.eliminated.H):
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def _packed(array: np.ndarray) -> str:
    return base64.b64encode(np.ascontiguousarray(array, dtype="<f8").tobytes()).decode()


def _unpacked(text: str) -> np.ndarray:
    return np.frombuffer(base64.b64decode(text), dtype="<f8").astype(float)
