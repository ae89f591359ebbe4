"""Calls as one piece of machine code: what XLA would end the process over, and that they are it."""

import re

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import tp_jax as tp
from tp_jax.simulation.one_piece import MARK, in_one_piece, put_rows

X = np.linspace(0.1, 1.0, 16)
LARGE = np.linspace(0.0, 1.0, 8192)


def turns(x, *unread):
    """A loop with a loop in it, which reads one of its arguments."""

    def inner(carry):
        k, x = carry
        return k + 1, jnp.sin(x) + 0.1 * x

    def outer(carry):
        k, x, total = carry
        _, x = jax.lax.while_loop(lambda c: c[0] < 5, inner, (0, x))
        return k + 1, x, jax.lax.dynamic_update_slice(total, x[None], (k, 0))

    return jax.lax.while_loop(lambda c: c[0] < 7, outer, (0, x, jnp.zeros((7, x.size))))[1:]


UNREAD = {
    "none": (),
    "a number": (1.0,),
    "an array": (X,),
    "a large array": (LARGE,),
    "integers": (np.arange(3),),
    "truth values": (np.array([True, False]), np.zeros(9000, bool)),
    "empty": (np.zeros((0, 3)),),
    "the same twice": (X, X),
}


@pytest.mark.parametrize("constant", [False, True], ids=["arguments", "constants"])
@pytest.mark.parametrize("case", UNREAD)
def test_arguments_that_nobody_reads_and_constants(case, constant):
    arguments = (X, *UNREAD[case])
    whole = lambda *a: in_one_piece(turns, *a)  # noqa: E731
    if constant:
        found = jax.jit(lambda: whole(*map(jnp.asarray, arguments)))()
    else:
        found = jax.jit(whole)(*arguments)
    for a, b in zip(found, turns(jnp.asarray(X)), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-13)


def test_results_that_nobody_reads():
    def first(x, y):
        return in_one_piece(lambda x, y: (turns(x)[0], 2.0 * y), x, y)[0]

    np.testing.assert_allclose(jax.jit(first)(X, X), turns(jnp.asarray(X))[0], rtol=1e-13)


def test_what_is_taken_from_around():
    def around(x, y, flags):
        return in_one_piece(lambda: jnp.where(flags, turns(x)[0], y[: x.size]))

    flags = X > 0.5
    expected = np.where(flags, turns(jnp.asarray(X))[0], LARGE[: X.size])
    np.testing.assert_allclose(jax.jit(around)(X, LARGE, flags), expected, rtol=1e-13)


def test_many_at_once():
    many = np.stack([X, 0.5 * X, 2.0 * X])
    found = jax.jit(jax.vmap(lambda x: in_one_piece(turns, x, LARGE)[1]))(many)
    for a, x in zip(found, many, strict=True):
        np.testing.assert_allclose(a, turns(jnp.asarray(x))[1], rtol=1e-13)


@pytest.mark.skipif(jax.default_backend() != "cpu", reason="of a CPU")
def test_a_users_own_program_has_the_mark():
    bench, ts = tp.presets.get("bench"), np.linspace(0.0, 0.1, 11)
    program = jax.jit(lambda m: tp.simulate(m, ts)).lower(bench).compile().as_text()
    calls = [line for line in program.splitlines() if " call(" in line]
    assert any(f'{k}="{v}"' in line for line in calls for k, v in MARK.items() if k[:3] == "xla")


def test_loops_are_left_alone_where_they_are_to_be(monkeypatch):
    marked = lambda: MARK.keys() & set(_words(jax.jit(whole).lower(X)))  # noqa: E731
    whole = lambda x: in_one_piece(turns, x)  # noqa: E731
    assert marked() or jax.default_backend() != "cpu"
    monkeypatch.setenv("TP_JAX_SMALL_LOOPS", "off")
    whole = lambda x: in_one_piece(turns, x)  # noqa: E731
    assert not marked()


def _words(lowered):
    return re.findall(r"\w+", lowered.as_text())


def test_rows_are_put_where_scattering_puts_them():
    rng = np.random.default_rng(5)
    table, lane = rng.normal(size=(4, 9, 3)), np.array([3, 0, 2])
    places, rows = rng.permuted(np.tile(np.arange(8), (3, 1)), axis=1).T, rng.normal(size=(8, 3, 3))
    expected = table.copy()
    expected[lane, places] = rows
    numbers = np.arange(36).reshape(4, 9)
    both = jax.jit(put_rows)((table, numbers), lane, places, (rows, places))
    np.testing.assert_array_equal(both[0], expected)
    numbers[lane, places] = places
    np.testing.assert_array_equal(both[1], numbers)
