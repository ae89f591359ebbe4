"""A Jacobian by columns, each without what is zero in it.

One linearisation serves all columns; along each of them zeros are known to be zeros, so that a
column costs what it holds. (A forward derivative for every column evaluates the function itself
every time, and what JAX takes to trace that grows with the number of columns.)
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax.extend.core import Literal
from jaxtyping import Array

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
    f: Callable[..., tuple], arguments: Sequence[Array], which: Sequence[int]
) -> list[list[Array | None]]:
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

    def of(*some):
        every = list(arguments)
        for k, x in zip(which, some, strict=True):
            every[k] = x
        return f(*every)

    at = [arguments[k] for k in which]
    _, forward = jax.linearize(of, *at)
    program = jax.make_jaxpr(forward)(*at)
    one = jnp.ones_like(at[0])
    found = []
    for j in range(len(which)):
        tangents: list[Array | None] = [None] * len(which)
        tangents[j] = one
        found.append(_along(program.jaxpr, program.consts, tangents))
    return found


def _along(program, constants, tangents: Sequence[Array | None]) -> list[Array | None]:
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


def _called(inner, read, along) -> list[Array | None]:
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
