"""Traced programs kept between runs: found again, never the wrong one, no harm from a bad file."""

import os
import threading
import time
from typing import NamedTuple

import jax
import jax.numpy as jnp
import pytest
from jax import export

from tp_jax import _stored
from tp_jax._stored import Stored


class Pair(NamedTuple):
    a: jax.Array
    b: jax.Array | None


export.register_namedtuple_serialization(Pair, serialized_name="tests.Pair")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setattr(_stored, "programs_folder", lambda: tmp_path)
    return tmp_path


class Traced:
    """A function of a static factor, in as many processes as one likes, and its traces."""

    def __init__(self, describe=repr):
        self.traces, self.describe = [], describe

    def process(self):
        def scaled(factor, pair):
            self.traces.append(factor)
            return Pair(factor * pair.a, pair.b)

        return Stored(scaled, 1, self.describe)


def test_is_traced_once_for_all_processes(folder):
    f = Traced()
    for _ in range(3):
        out = f.process()(2.0, Pair(jnp.arange(3.0), None))
        assert isinstance(out, Pair)
        assert out.a.tolist() == [0.0, 2.0, 4.0]
        assert out.b is None
    assert f.traces == [2.0]
    assert len(list(folder.iterdir())) == 1


def test_another_for_other_static_arguments_shapes_and_trees(folder):
    f = Traced()
    calls = [
        (2.0, Pair(jnp.ones(3), None)),
        (3.0, Pair(jnp.ones(3), None)),
        (2.0, Pair(jnp.ones(4), None)),
        (2.0, Pair(jnp.ones(3), jnp.ones(1))),
        (2.0, Pair(jnp.ones(3, dtype=int), None)),
    ]
    for _ in range(2):
        process = f.process()
        for factor, pair in calls:
            assert (process(factor, pair).a == factor * pair.a).all()
    assert len(f.traces) == len(list(folder.iterdir())) == len(calls)


def test_static_arguments_that_are_described_alike_share_a_program(folder):
    """A second one of them loads nothing: what a process holds does not grow with their number."""
    f = Traced(describe=lambda factor: str(factor % 10.0))
    process, pair = f.process(), Pair(jnp.ones(3), None)
    assert all((process(factor, pair).a == 2.0).all() for factor in (2.0, 12.0, 22.0))
    assert f.traces == [2.0]
    assert len(process._ready) == 1


def test_another_for_another_source(folder, monkeypatch):
    f, pair = Traced(), Pair(jnp.ones(3), None)
    f.process()(2.0, pair)
    monkeypatch.setattr(_stored, "source_digest", lambda: "changed")
    f.process()(2.0, pair)
    assert len(f.traces) == len(list(folder.iterdir())) == 2


def test_what_cannot_be_described_is_not_kept(folder):
    f = Traced(describe=lambda _: None)
    for _ in range(2):
        assert f.process()(2.0, Pair(jnp.ones(2), None)).a.tolist() == [2.0, 2.0]
    assert len(f.traces) == 2
    assert not list(folder.iterdir())


def test_nothing_is_kept_without_a_cache(monkeypatch):
    monkeypatch.setattr(_stored, "programs_folder", lambda: None)
    assert Traced().process()(2.0, Pair(jnp.ones(2), None)).a.tolist() == [2.0, 2.0]


@pytest.mark.parametrize("content", [b"", b"not a program", b"\0" * 400, "half", "flipped", "bare"])
def test_a_spoiled_or_foreign_file_is_replaced(folder, content):
    f, pair = Traced(), Pair(jnp.ones(2), None)
    f.process()(2.0, pair)
    (file,) = folder.iterdir()
    good = file.read_bytes()
    changed = {
        "half": good[: len(good) // 2],
        "flipped": good[:-9] + bytes([good[-9] ^ 1]) + good[-8:],
        "bare": good[_stored.BEGIN :],  # as files were before they had a head
    }
    file.write_bytes(changed.get(content, content))
    assert f.process()(2.0, pair).a.tolist() == [2.0, 2.0]
    assert len(f.traces) == 2
    f.process()(2.0, pair)
    assert len(f.traces) == 2


def test_use_is_noted(folder):
    f, pair = Traced(), Pair(jnp.ones(2), None)
    f.process()(2.0, pair)
    (file,) = folder.iterdir()
    os.utime(file, (1e9, 1e9))
    f.process()(2.0, pair)
    assert file.stat().st_mtime > 1.5e9


@pytest.mark.parametrize("what", ["_processor.name", "platform.python_version"])
def test_another_for_another_processor_or_python(folder, monkeypatch, what):
    f, pair = Traced(), Pair(jnp.ones(3), None)
    f.process()(2.0, pair)
    module, name = what.split(".")
    monkeypatch.setattr(getattr(_stored, module), name, lambda: "another")
    f.process()(2.0, pair)
    assert len(f.traces) == len(list(folder.iterdir())) == 2


def test_a_folder_that_cannot_be_written_to_does_no_harm(tmp_path, monkeypatch):
    monkeypatch.setattr(_stored, "programs_folder", lambda: tmp_path / "gone")
    assert Traced().process()(2.0, Pair(jnp.ones(2), None)).a.tolist() == [2.0, 2.0]


def test_traces_like_any_function(folder):
    process = Traced().process()
    value, slope = jax.jvp(lambda a: process(2.0, Pair(a, None)).a, (jnp.ones(2),), (jnp.ones(2),))
    assert value.tolist() == slope.tolist() == [2.0, 2.0]


def test_threads_wait_for_one_another(folder):
    f = Traced()
    process, results = f.process(), []

    def call():
        results.append(process(2.0, Pair(jnp.ones(3), None)).a.tolist())

    threads = [threading.Thread(target=call) for _ in range(4)]
    for t in threads:
        t.start()
    for t in threads:
        t.join()
    assert f.traces == [2.0]
    assert results == [[2.0] * 3] * 4


def test_digest_of_the_source_knows_every_file():
    assert len(_stored.source_digest()) == 64


@pytest.mark.parametrize(("seconds", "times"), [(0.0, 1), (1e9, 0)])
def test_memory_of_a_large_program_is_given_back_once(folder, monkeypatch, seconds, times):
    calls = []
    monkeypatch.setattr(_stored, "LARGE", seconds)
    monkeypatch.setattr(_stored, "release", lambda: calls.append(1))
    f = Traced().process()
    for _ in range(3):
        f(2.0, Pair(jnp.arange(3.0), None))
    assert len(calls) == times


def test_two_are_compiled_at_once_and_no_more(folder):
    inside, most = [], []
    lock = threading.Lock()

    def watched(factor, pair):  # traced, so called, where a program is made
        with lock:
            inside.append(factor)
            most.append(len(inside))
        time.sleep(0.05)
        with lock:
            inside.remove(factor)
        return Pair(factor * pair.a, pair.b)

    f = Stored(watched, 1, repr)
    threads = [
        threading.Thread(target=f, args=(float(k), Pair(jnp.ones(3), None))) for k in range(6)
    ]
    for t in threads:
        t.start()
    for t in threads:
        t.join()
    assert len(most) == 6
    assert max(most) == 2


@pytest.mark.skipif(_stored.fcntl is None, reason="locks of files are those of POSIX")
def test_is_compiled_by_one_process_while_others_wait(folder):
    """A lock belongs to an open file, so threads that open it stand for processes."""
    f, pair, traced = Traced(), Pair(jnp.ones(3), None), threading.Event()
    slow = f.process()
    whole = slow.function

    def slowly(factor, pair):
        traced.set()
        time.sleep(0.3)
        return whole(factor, pair)

    slow.function = slowly
    slowly.__name__, slowly.__qualname__ = whole.__name__, whole.__qualname__
    first = threading.Thread(target=slow, args=(2.0, pair))
    first.start()
    assert traced.wait(10.0)
    f.process()(2.0, pair)
    first.join()
    assert f.traces == [2.0]
    assert len(list(folder.iterdir())) == 1  # and no lock
