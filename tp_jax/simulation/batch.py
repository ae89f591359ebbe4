"""Many pendulums handed to the engine: gathered, cut into shares for the cores, and pieces."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import jax
import numpy as np
from jaxtyping import Float

from tp_jax.model.arrays import AnyArray
from tp_jax.simulation.parts import Parts

PIECE = 1 << 25
"""Bytes of motions that one call returns on a CPU, at most: what is larger is fresh memory every
time, which the system clears first."""


class Batch(NamedTuple):
    """p: (P, N) numbers; states: (c, N) to start from."""

    p: Float[np.ndarray, "P N"]
    states: Float[np.ndarray, "c N"]


def is_many(parts: Parts, y0: AnyArray | None) -> bool:
    """True where a pendulum's numbers or its starts have an axis of members."""
    return any(np.ndim(v) for v in parts.values) or (y0 is not None and np.ndim(y0) == 2)


def gathered(parts: Parts, y0: AnyArray | None) -> Batch:
    """Numbers and starts of all members, one if nothing has their axis.

    Raises:
        ValueError: where shapes do not fit.
    """
    states = np.zeros(parts.n_states) if y0 is None else np.asarray(y0, float)
    for name, v in zip(parts.names, parts.values, strict=True):
        if np.ndim(v) > 1:
            raise ValueError(
                f"Numbers of pendulums must have shape () or (N,), but {name} has shape {v.shape}."
            )
    sizes = {np.shape(v)[0] for v in parts.values if np.ndim(v)}
    sizes |= {len(states)} if states.ndim == 2 else set()
    if len(sizes) > 1:
        raise ValueError(f"All members must be equally many, but there are {sorted(sizes)}.")
    if sizes == {0}:
        raise ValueError("There must be at least one pendulum.")
    if states.shape[-1:] != (parts.n_states,) or states.ndim > 2:
        raise ValueError(
            f"Argument `y0` must have shape ({parts.n_states},) or (N, {parts.n_states}), "
            f"but has {states.shape}."
        )
    many = sizes.pop() if sizes else 1
    p = np.stack([np.broadcast_to(np.asarray(v, float), (many,)) for v in parts.values])
    return Batch(p, np.broadcast_to(states, (many, parts.n_states)).T)


def lanes(width: int, many: int) -> int:
    """Lanes side by side: so many on a CPU, elsewhere all, rounded up as `in_pieces` does."""
    return width if jax.default_backend() == "cpu" else 1 << (many - 1).bit_length()


def in_pieces(
    run: Callable[[np.ndarray, int], None],
    many: int,
    *,
    width: int,
    bytes_each: int,
    threads: int | None = None,
) -> None:
    """Runs all members, on all cores of a CPU.

    Args:
        run: of the members' numbers (room,), and how many of them count; the rest fills up, so
            that the next size is not another program.
        many: members.
        width: lanes side by side, see `lanes`.
        bytes_each: of a member's result.
        threads: of a CPU; as many as there are cores if None.
    """
    on_cpu = jax.default_backend() == "cpu"
    shares = min(threads or threads_worthwhile(), -(-many // width)) if on_cpu else 1
    room = 1 << (-(-many // shares) - 1).bit_length()
    if on_cpu:
        room = min(room, max(width, 1 << max(PIECE // bytes_each, 1).bit_length() - 1))

    def several(turn: np.ndarray) -> None:
        for first in range(0, len(turn), room):
            part = turn[first : first + room]
            run(np.concatenate([part, np.repeat(part[:1], room - len(part))]), len(part))

    if shares == 1:
        several(np.arange(many))
        return
    # Every other run to the same thread: neighbours tend to take equally long.
    with ThreadPoolExecutor(shares) as pool:
        list(pool.map(several, [np.arange(many)[i::shares] for i in range(shares)]))


def threads_worthwhile() -> int:
    """Threads that share the work: as many as this process has cores of a CPU, elsewhere one."""
    if jax.default_backend() != "cpu":
        return 1
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
