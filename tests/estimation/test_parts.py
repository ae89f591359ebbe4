"""A fit in parts: the sums of all parts are those of the whole."""

import numpy as np
import pytest

from tests.rigs import synthetic_campaign, synthetic_values
from tp_jax.estimation import parts as module
from tp_jax.estimation.parts import parts
from tp_jax.estimation.prepared_campaign import prepare_campaign
from tp_jax.estimation.variable_projection import fit
from tp_jax.gap.free_structure import free_scores, free_structure
from tp_jax.gap.screen import screen


@pytest.fixture(scope="module")
def fitted():
    setting = prepare_campaign(synthetic_campaign(duration=3.0))
    problem = setting.problem(setting.horizons[-1])
    return setting, fit(problem, synthetic_values(setting), setting.unknowns(), max_iterations=2)


def in_small_parts(monkeypatch):
    """Parts of few windows."""
    monkeypatch.setattr(module.parts, "__defaults__", (20_000,))


def test_every_window_is_in_one_part(fitted):
    _, found = fitted
    windows, rows = found.linearisation.r.shape
    assert len(list(parts(found, 10))) == 1
    pieces = list(parts(found, 10, at_once=25 * rows))
    assert len(pieces) > 1
    np.testing.assert_array_equal(np.concatenate([w for w, _ in pieces]), np.arange(windows))
    r = sum((part.linearisation.r**2).sum() for _, part in pieces)
    np.testing.assert_allclose(r, (found.linearisation.r**2).sum())
    for _, part in pieces:
        again = part.problem.linearise(part.values, part.states, ())
        np.testing.assert_allclose(again.r, part.linearisation.r, atol=1e-6)


def test_a_screen_in_parts(fitted, monkeypatch):
    setting, found = fitted
    whole = screen(found, setting, states=False)
    in_small_parts(monkeypatch)
    pieces = screen(found, setting, states=False)
    sd = np.sqrt(np.diag(whole.information))
    np.testing.assert_allclose(pieces.total / sd, whole.total / sd, rtol=1e-6, atol=1e-6)
    V, W = pieces.by_block.dense(), whole.by_block.dense()
    np.testing.assert_allclose(V / np.outer(sd, sd), W / np.outer(sd, sd), atol=1e-8)


def test_the_test_without_candidates_in_parts(fitted, monkeypatch):
    setting, found = fitted
    whole, every = free_structure(setting, found), free_scores(setting, found)
    in_small_parts(monkeypatch)
    assert free_structure(setting, found).source == whole.source
    np.testing.assert_allclose(free_structure(setting, found).ratio, whole.ratio, rtol=1e-8)
    again = free_scores(setting, found)
    np.testing.assert_allclose(again.g * every.unit, every.g * every.unit, atol=1e-6)
