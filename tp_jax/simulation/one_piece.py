"""A loop as one piece of machine code, whatever the process is set to.

Problem: on a CPU, XLA runs a loop operation by operation, each a call of its own, unless what the
loop carries is below a limit of one kilobyte. A simulation is such a loop and ten times faster in
one piece. The limit is a flag of the whole process, read once, before its first program: nothing
that a library may set when one of its functions is called, and nothing that a user's own `jax.jit`
could pass on.

Choice: what XLA does with a small loop is to mark a call of it, and a mark may be given from here
as well. It holds for that call alone, in any program and under any transformation. Where XLA knows
no such mark, or on another device, the call runs as before.

XLA asks three things of such a call, and ends the process where one is missing: every argument is
read, none is a constant, and no operation is a scatter. So what the function takes from its
surroundings becomes an argument, arguments have a number added that no compiler knows to be zero,
and no result is had without a look at the first element of each. `put_rows` replaces the scatter.
"""

import functools
import math
from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
from jax.custom_batching import custom_vmap
from jax.experimental.xla_metadata import set_xla_metadata
from jax.extend.core import ClosedJaxpr, Literal, jaxpr_as_fun
from jaxtyping import Array, Bool, Float, Int

from tp_jax._compiler import loops_left_alone
from tp_jax.model.arrays import AnyArray

MARK = {"xla_cpu_small_call": "true", "inlineable": "false"}

SMALL = 4096
"""Elements of arrays that go into one argument with others."""

UNKNOWN = 200.0
"""Turns of a loop that XLA does not play through to know its end: it does so up to 128."""


def in_one_piece(function: Callable, *args: Any) -> Any:
    """Value of `function(*args)`, of pytrees of arrays, as one piece of machine code on a CPU.

    Mapped by `jax.vmap` it is no longer one piece, since what is written at places of a batch
    becomes a scatter. Not to be differentiated: what a derivative adds is neither hidden nor read.
    Its callers have rules of their own for both.
    """
    if not marked():
        return function(*args)
    leaves, tree = jax.tree.flatten(args)
    program, result = jax.make_jaxpr(
        lambda *x: function(*jax.tree.unflatten(tree, x)), return_shape=True
    )(*leaves)
    n = len(program.consts)
    given = [jnp.asarray(x) for x in (*program.consts, *leaves)]

    def plain(*given: Array) -> list[Array]:
        return jaxpr_as_fun(ClosedJaxpr(program.jaxpr, given[:n]))(*given[n:])

    @custom_vmap
    def called(*given: Array) -> list[Array]:
        packed, unpack = _packed(given)

        def whole(*packed: Array) -> list[Array]:
            with set_xla_metadata(**dict.fromkeys(MARK)):  # calls inside are inlined as ever
                never = _never(packed)
                return [_having_read(x, never) for x in plain(*unpack(packed))]

        zero = 0.0 * jax.lax.while_loop(lambda x: x < UNKNOWN, lambda x: x + 1.0, 0.0)
        assert isinstance(zero, Array)  # a loop ends in an array, though it begins with a float
        with set_xla_metadata(**MARK):
            return jax.jit(whole)(*(_hidden(x, zero) for x in packed))

    @called.def_vmap
    def _(axis_size, batched, *given):
        axes = [0 if b else None for b in batched]
        out = jax.vmap(plain, in_axes=axes, axis_size=axis_size)(*given)
        return out, [True] * len(out)

    return jax.tree.unflatten(jax.tree.structure(result), called(*given))


def loops_in_one_piece(function: Callable, *args: Any) -> Any:
    """Value of `function(*args)`, each of its outermost loops as one piece.

    For functions that do what one piece cannot do, such as a check that may raise, before or after.
    """
    leaves, tree = jax.tree.flatten(args)
    program, result = jax.make_jaxpr(
        lambda *x: function(*jax.tree.unflatten(tree, x)), return_shape=True
    )(*leaves)
    out = _with_loops_marked(program.jaxpr, program.consts, leaves)
    return jax.tree.unflatten(jax.tree.structure(result), out)


def _with_loops_marked(
    program, consts: Sequence[AnyArray | float], args: Sequence[AnyArray | float]
) -> list[AnyArray | float]:
    values = dict(zip(program.constvars, consts, strict=True))
    values.update(zip(program.invars, args, strict=True))
    of = lambda v: v.val if isinstance(v, Literal) else values[v]  # noqa: E731
    for e in program.eqns:
        read, kind = [of(v) for v in e.invars], e.primitive.name
        if kind == "while":
            out = in_one_piece(functools.partial(e.primitive.bind, **e.params), *read)
        elif kind in ("jit", "pjit"):
            inner = e.params["jaxpr"]
            out = _with_loops_marked(inner.jaxpr, inner.consts, read)
        else:
            out = e.primitive.bind(*read, **e.primitive.get_bind_params(e.params))
            out = out if e.primitive.multiple_results else [out]
        values.update(zip(e.outvars, out, strict=True))
    return [of(v) for v in program.outvars]


def _packed(arrays: Sequence[Array]) -> tuple[list[Array], Callable]:
    """Fewer arrays, and a function that takes them apart again: small ones of a kind in one.

    Of those in one, some may be read by nobody.
    """
    kinds: dict[Any, list[int]] = {}
    for k, x in enumerate(arrays):
        if x.size <= SMALL:
            kinds.setdefault(x.dtype, []).append(k)
    alone = [k for k, x in enumerate(arrays) if x.size > SMALL]
    packed = [jnp.concatenate([jnp.ravel(arrays[k]) for k in kind]) for kind in kinds.values()]
    shapes = [x.shape for x in arrays]

    def unpack(packed: Sequence[Array]) -> list[Array]:
        found: dict[int, Array] = dict(zip(alone, packed[len(kinds) :], strict=True))
        for kind, x in zip(kinds.values(), packed, strict=False):
            at = 0
            for k in kind:
                size = math.prod(shapes[k])
                found[k] = x[at : at + size].reshape(shapes[k])
                at += size
        return [found[k] for k in range(len(shapes))]

    return packed + [arrays[k] for k in alone], unpack


def _never(arrays: Sequence[Array]) -> Bool[Array, ""]:
    """False, in a way that no compiler knows without a look at each of the arrays."""
    never = jnp.array(False)
    for each in arrays:
        if each.size:
            first = each[(0,) * each.ndim].astype(float)
            never = never | ((first > 1.0) & (first < 0.0))
    return never


def _having_read(x: Array, never: Bool[Array, ""]) -> Array:
    """`x`, which takes `never` to be known.

    All results do: one that nobody reads is left out, and what only it had read would be unread.
    """
    if not x.size:
        return x
    first = x[(slice(0, 1),) * x.ndim]
    first = jnp.where(never, jnp.zeros_like(first), first)
    return jax.lax.dynamic_update_slice(x, first, (0,) * x.ndim)


def marked() -> bool:
    """True where there are marks: on a CPU, unless loops are to be left alone (`_config`)."""
    return jax.default_backend() == "cpu" and not loops_left_alone()


def put_rows(
    tables: Sequence[Array],
    lane: Int[Array, " L"],
    places: Int[Array, "... L"],
    rows: Sequence[Array],
) -> tuple[Array, ...]:
    """Tables (N, n, ...) with rows (..., L, ...) written where they belong.

    Args:
        tables: one for each kind of row.
        lane: the first index of a row in its table.
        places: the second.
        rows: for each table.
    """
    if not marked():
        return tuple(
            table.at[lane, places].set(row, mode="promise_in_bounds")
            for table, row in zip(tables, rows, strict=True)
        )
    # lane after lane, so that what is written lies side by side
    ahead = places.ndim - 1
    flat = [
        jnp.moveaxis(row, ahead, 0).reshape(places.size, 1, 1, *table.shape[2:])
        for table, row in zip(tables, rows, strict=True)
    ]
    where = jnp.moveaxis(places, ahead, 0).reshape(-1)
    lanes = jnp.repeat(lane, places.size // lane.size)

    def one(i: Array, tables: tuple[Array, ...]) -> tuple[Array, ...]:
        return tuple(
            jax.lax.dynamic_update_slice(
                table, row[i], (lanes[i], where[i], *[0] * (table.ndim - 2))
            )
            for table, row in zip(tables, flat, strict=True)
        )

    return jax.lax.fori_loop(0, places.size, one, tuple(tables))


def _hidden(x: Array, zero: Float[Array, ""]) -> Array:
    """`x` as something no compiler knows."""
    if x.dtype == bool:
        return x | (zero > 1.0)
    if jnp.issubdtype(x.dtype, jnp.floating):
        return x + zero.astype(x.dtype)
    return x + (zero > 1.0).astype(x.dtype)


__all__ = ["in_one_piece", "loops_in_one_piece", "marked", "put_rows"]
