"""Figures of a multi-start search."""

from types import SimpleNamespace
from unittest.mock import Mock

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from tp_jax.estimation.identification import Identification
from tp_jax.report import style
from tp_jax.report.starts import FIGURES

NAMES = ("k", "M1", "Tst", "phase")


def result(costs):
    """As `identify` returns it, with as much of it as is drawn."""
    rng = np.random.default_rng(0)
    trials = []
    for i, cost in enumerate(costs):
        x = np.array([0.5, 0.005, 0.0, -0.01]) * (1.0 if cost < 11.0 else 3.0)
        point = None if i == 0 else np.array([*10.0 ** rng.uniform(-5, 2, 3), 0.3])
        trials.append(
            SimpleNamespace(start=SimpleNamespace(point=point), end=SimpleNamespace(cost=cost, x=x))
        )
    unknowns = tuple(SimpleNamespace(name=n) for n in NAMES)
    fit = SimpleNamespace(unknowns=unknowns)
    return Mock(spec=Identification, trials=tuple(trials), fit=fit)


def lines(figure):
    return {line.get_label(): line for axes in figure.axes for line in axes.get_lines()}


def test_waterfall_shows_who_reached_the_best():
    figure = FIGURES["waterfall"](result([10.0, 500.0, 10.4, np.inf, 10.0]))
    drawn = lines(figure)
    assert drawn["reached the best"].get_xdata().tolist() == [1, 2, 3]
    assert drawn["ended elsewhere"].get_ydata().tolist() == [490.0]
    assert drawn["came to nothing"].get_xdata().tolist() == [5]
    used = {drawn[n].get_color() for n in ("reached the best", "ended elsewhere")}
    assert used == {style.AFTER, style.BEFORE}
    markers = {drawn[n].get_marker() for n in ("reached the best", "ended elsewhere")}
    assert len(markers) == 2  # told apart without colour too


def test_unknowns_that_have_a_ratio_are_drawn():
    figure = FIGURES["parameters"](result([10.0, 500.0, 10.4]))
    (axes,) = figure.axes
    assert [t.get_text() for t in axes.get_yticklabels()] == ["k", "M1"]
    drawn = lines(figure)
    np.testing.assert_allclose(drawn["reached the best"].get_xdata(), 1.0)
    np.testing.assert_allclose(drawn["ended elsewhere"].get_xdata(), 3.0)
    assert drawn["drawn"].get_xdata().size == 4


@pytest.mark.parametrize("costs", [[10.0], [10.0, np.inf, np.inf]])
@pytest.mark.parametrize("name", FIGURES)
def test_few_starts_are_drawn_too(name, costs, tmp_path):
    path = tmp_path / f"{name}.png"
    style.save(FIGURES[name](result(costs)), path)
    assert path.read_bytes().startswith(b"\x89PNG")
