"""A Jacobian by columns, each without what is zero in it, and some of them chosen by data.

One linearisation serves all columns; along each of them zeros are known to be zeros, so that a
column costs what it holds. (A forward derivative for every column evaluates the function itself
every time, and what JAX takes to trace that grows with the number of columns.)
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax.extend.core import Literal
from jaxtyping import Array, Bool, Int

from tp_jax.model.arrays import AnyArray

_ADDS = {"add_any", "add", "sub"}


class _Program(NamedTuple):
    """The parts of a jaxpr that are read here.

    A view of our own, since what `Jaxpr.replace` lets one change differs between versions of JAX.
    """

    constvars: Sequence[Any]
    invars: Sequence[Any]
    outvars: Sequence[Any]
    eqns: Sequence[Any]


def columns(
    f: Callable[..., tuple], arguments: Sequence[AnyArray], which: Sequence[int]
) -> list[list[AnyArray | None]]:
    """Derivatives of all results of `f(*arguments)` by some of the arguments.

    Args:
        f: elementwise function of arrays (L,), returning a tuple of them.
        arguments: where.
        which: places of the arguments to differentiate by.

    Returns:
        For each of `which` a derivative (L,) for every result, None where it is zero.
    """
    if not which:
        return []
    program, constants, one = _linearised(f, arguments, which)
    found = []
    for j in range(len(which)):
        tangents: list[AnyArray | None] = [None] * len(which)
        tangents[j] = one
        found.append(_along(program, constants, tangents))
    return found


def some_columns(
    f: Callable[..., tuple],
    arguments: Sequence[AnyArray],
    which: Sequence[int],
    chosen: Int[Array, " d"],
    wanted: Bool[np.ndarray, "k w"],
) -> list[AnyArray | None]:
    """Derivatives of all results of `f(*arguments)` by those arguments that are chosen.

    Of fifty effects' numbers sixteen are asked for, and which is data: were all columns evaluated
    and some taken, most would be for nothing, and each would evaluate anew what they share. So the
    program goes through the chosen ones, and what they share is there before.

    Args:
        f, arguments: as for `columns`.
        which: places of the arguments that may be chosen.
        chosen: places in `which`; beyond its end for zeros.
        wanted: by result and place in `which`; others count as zero.

    Returns:
        For each result (d, ...), None where nothing of it is wanted.
    """
    results = np.flatnonzero(wanted.any(axis=1)).tolist()
    out: list[AnyArray | None] = [None] * len(wanted)
    if not results:
        return out
    program, constants, one = _linearised(f, arguments, which)
    zero = jnp.zeros_like(one)

    def branch(j: int) -> Callable[[list], tuple]:
        def column(constants: list) -> tuple:
            tangents: list[AnyArray | None] = [None] * len(which)
            tangents[j] = jnp.ones_like(one)
            found = _along(program, constants, tangents)
            return tuple(
                zero if found[i] is None or not wanted[i, j] else found[i] for i in results
            )

        return column

    branches = [branch(j) for j in range(len(which))]
    branches.append(lambda _: (zero,) * len(results))

    def one_more(i: Array, tables: tuple) -> tuple:
        column = jax.lax.switch(chosen[i], branches, constants)
        return tuple(table.at[i].set(x) for table, x in zip(tables, column, strict=True))

    empty = jnp.zeros((chosen.size, *one.shape))
    tables = jax.lax.fori_loop(0, chosen.size, one_more, (empty,) * len(results))
    for i, table in zip(results, tables, strict=True):
        out[i] = table
    return out


def _linearised(f, arguments: Sequence[AnyArray], which: Sequence[int]):
    """A linear program from changes of some arguments to those of the results, its constants, 1."""

    def of(*some):
        every = list(arguments)
        for k, x in zip(which, some, strict=True):
            every[k] = x
        return f(*every)

    at = [arguments[k] for k in which]
    _, forward = jax.linearize(of, *at)
    program = jax.make_jaxpr(forward)(*at)
    return program.jaxpr, program.consts, jnp.ones_like(at[0])


def _along(program, constants, tangents: Sequence[AnyArray | None]) -> list[AnyArray | None]:
    """Results of a linear program; None stands for a zero."""
    values = dict(zip(program.constvars, constants, strict=True))
    # None for a tangent that is zero; what is not a tangent is never None
    values.update(zip(program.invars, tangents, strict=True))
    linear = set(program.invars)

    def of(v):
        return v.val if isinstance(v, Literal) else values[v]

    for e in program.eqns:
        read = [of(v) for v in e.invars]
        along = [not isinstance(v, Literal) and v in linear for v in e.invars]
        if any(along):
            linear.update(e.outvars)
            if all(x is None for x, is_tangent in zip(read, along, strict=True) if is_tangent):
                values.update(dict.fromkeys(e.outvars))
                continue
        inner = e.params.get("jaxpr") if e.primitive.name in ("jit", "pjit") else None
        if inner is not None and any(along):
            out = _called(inner, read, along)
        elif e.primitive.name in _ADDS and None in read:
            a, b = read
            out = [a if b is None else -b if e.primitive.name == "sub" else b]
        else:
            read = [
                jnp.zeros(v.aval.shape, v.aval.dtype) if x is None else x
                for x, v in zip(read, e.invars, strict=True)
            ]
            out = e.primitive.bind(*read, **e.params)
            out = out if e.primitive.multiple_results else [out]
        values.update(zip(e.outvars, out, strict=True))
    return [of(v) for v in program.outvars]


def _called(inner, read, along) -> list[AnyArray | None]:
    """A call within a linear program: its constant arguments become constants."""
    program = inner.jaxpr
    fixed = {v: x for v, x, t in zip(program.invars, read, along, strict=True) if not t}
    tangents = [(v, x) for v, x, t in zip(program.invars, read, along, strict=True) if t]
    view = _Program(
        constvars=[*program.constvars, *fixed],
        invars=[v for v, _ in tangents],
        outvars=program.outvars,
        eqns=program.eqns,
    )
    return _along(view, [*inner.consts, *fixed.values()], [x for _, x in tangents])
