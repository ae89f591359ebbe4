"""A pendulum taken apart into the numbers that the engine works with, and put together again."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import equinox as eqx
import jax
import numpy as np
from jaxtyping import Array

from tp_jax.model.pendulum import AbstractTorsionPendulum


class Parts(NamedTuple):
    """Numbers of a pendulum, or of many that differ in nothing but numbers.

    names: of the numbers, by their place in the pendulum ("spring.k"); values: each () or (N,);
    model_of: the pendulum with other such numbers; eps: places of the two smoothing slopes in
    `values`; n_states: components of the state; template: a pendulum of the same structure with
    all numbers zero, to compile for.
    """

    names: tuple[str, ...]
    values: tuple[Array, ...]
    model_of: Callable[[Sequence[Array]], AbstractTorsionPendulum]
    eps: tuple[int, int]
    n_states: int
    template: AbstractTorsionPendulum

    def field(self, t: Array, y: tuple, p: Sequence[Array]) -> tuple:
        """Derivatives of the state with the numbers p, elementwise over lanes."""
        return self.model_of(p).derivative(t, y)


def take_apart(model: AbstractTorsionPendulum) -> Parts:
    """Takes a pendulum apart.

    Numbers are leaves of no axis, or of one that runs over the members of a batch. What has more
    (the knots of a measured drive: `knots` and `coefficients`) belongs to the structure: shared
    by all, and not differentiated by.
    """
    arrays, static = eqx.partition(model, eqx.is_inexact_array)
    paths, tree = jax.tree_util.tree_flatten_with_path(arrays)
    names = [jax.tree_util.keystr(path, simple=True, separator=".") for path, _ in paths]
    leaves = [leaf for _, leaf in paths]
    fixed = [name.rsplit(".")[-1] in ("knots", "coefficients") for name in names]
    numbers = [i for i, f in enumerate(fixed) if not f]

    def model_of(p):
        whole = list(leaves)
        for i, value in zip(numbers, p, strict=True):
            whole[i] = value
        return eqx.combine(jax.tree.unflatten(tree, whole), static)

    zero = np.zeros(())  # on the host: an operation on a device costs as much as a hundred steps
    zeros = [leaf if f else zero for leaf, f in zip(leaves, fixed, strict=True)]
    template = eqx.combine(jax.tree.unflatten(tree, zeros), static)
    kept = tuple(names[i] for i in numbers)
    eps = tuple(kept.index(n) for n in ("bearing.eps", "contact.eps") if n in kept)
    return Parts(
        kept,
        tuple(leaves[i] for i in numbers),
        model_of,
        (eps[0], eps[-1]),
        model.n_states,
        template,
    )
