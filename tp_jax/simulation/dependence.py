"""Dependence of the results of a function on its arguments, by structure.

A derivative that is zero by structure should cost nothing. JAX drops it while it differentiates
one function, but a Jacobian put together column by column no longer knows.
"""

from collections.abc import Callable

import jax
import numpy as np


def dependence(f: Callable, *arguments: jax.ShapeDtypeStruct) -> np.ndarray:
    """Boolean matrix: does output i of `f(*arguments)`, a tuple of arrays, depend on input j?

    A "no" is certain; a "yes" may be a zero that the structure does not show.
    """
    return _walk(jax.make_jaxpr(f)(*arguments).jaxpr)


def _walk(jaxpr) -> np.ndarray:
    n = len(jaxpr.invars)
    known = {v: np.eye(n, dtype=bool)[i] for i, v in enumerate(jaxpr.invars)}

    def of(v) -> np.ndarray:
        # literals are not hashable, and constants are not in the table
        return known.get(v, np.zeros(n, bool)) if not hasattr(v, "val") else np.zeros(n, bool)

    for eqn in jaxpr.eqns:
        inputs = np.stack([of(v) for v in eqn.invars]) if eqn.invars else np.zeros((0, n), bool)
        inner = eqn.params.get("jaxpr", eqn.params.get("call_jaxpr"))
        inner = getattr(inner, "jaxpr", inner)
        if eqn.primitive.name in ("jit", "pjit", "closed_call", "custom_jvp_call") and inner:
            through = _walk(inner)
        else:
            through = np.ones((len(eqn.outvars), len(eqn.invars)), bool)
        for row, v in zip(through, eqn.outvars, strict=True):
            known[v] = inputs[row].any(axis=0) if row.any() else np.zeros(n, bool)
    return np.stack([of(v) for v in jaxpr.outvars])
