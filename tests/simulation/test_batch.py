"""Many pendulums are handed to the engine in shares and pieces, each once."""

import threading

import jax
import numpy as np
import pytest

import tp_jax as tp
from tp_jax.simulation import batch


@pytest.fixture
def calls():
    """A run that keeps what it is given, and that."""
    seen, lock = [], threading.Lock()

    def run(index, active):
        with lock:
            seen.append((index, active))

    run.seen = seen
    return run


@pytest.mark.parametrize("threads", [1, 2, 3])
@pytest.mark.parametrize("many", [1, 2, 37, 64])
def test_every_member_runs_once_and_all_pieces_are_alike(calls, many, threads, monkeypatch):
    monkeypatch.setattr(batch, "PIECE", 1 << 10)
    batch.in_pieces(calls, many, width=4, bytes_each=100, threads=threads)
    ran = np.concatenate([index[:active] for index, active in calls.seen])
    assert sorted(ran) == list(range(many))
    (room,) = {len(index) for index, _ in calls.seen}
    assert room <= max(4, (1 << 10) // 100)
    for index, active in calls.seen:  # what fills up is a member too
        assert set(index[active:]) <= {index[0]}


def test_a_result_too_large_for_any_piece_goes_by_lanes(calls, monkeypatch):
    monkeypatch.setattr(batch, "PIECE", 1)
    batch.in_pieces(calls, 9, width=4, bytes_each=1 << 20, threads=1)
    assert [active for _, active in calls.seen] == [4, 4, 1]


def test_sensitivities_in_pieces_are_those_at_once(monkeypatch):
    bench = tp.presets.values("bench")
    k = np.linspace(0.4, 0.5, 70)
    models = jax.vmap(lambda k: tp.presets.double_pendulum(**bench | {"k": k}))(k)
    ts = np.linspace(0.0, 0.05, 6)
    monkeypatch.setattr(batch, "threads_worthwhile", lambda: 2)
    together = tp.sensitivities(models, ts, by=["B2"])
    monkeypatch.setattr(batch, "PIECE", 1)
    apart = tp.sensitivities(models, ts, by=["B2"])
    np.testing.assert_allclose(apart.phi2, together.phi2, rtol=1e-10, atol=1e-14)
    np.testing.assert_allclose(apart.error, together.error, rtol=1e-6, atol=1e-14)
