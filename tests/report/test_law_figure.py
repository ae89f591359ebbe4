"""The curve of a law that was learned, in figures, sentences and tables."""

import copy

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from tp_jax.report import figures, pictures, style, summary, verdict, words
from tp_jax.report.html import render
from tp_jax.results.diagnosis import Cause, Curve, DiagnosisRecord

X = np.linspace(-0.6, 0.7, 101)
Y = 0.4 * np.cos(3.0 * X)


@pytest.fixture
def learned(made):
    """A diagnosis whose first cause is a curve."""
    diagnosis = copy.deepcopy(made("explained"))
    edges = np.linspace(X[0], X[-1], 41)
    diagnosis["causes"][0] |= {
        "effect": "bearing_dry.phi1",
        "kind": "learned",
        "location": "bearing",
        "channel": "column",
        "formula": "0.4 cos 3 φ1",
        "curve": {
            "argument": "φ1",
            "unit": "rad",
            "x": X.tolist(),
            "y": Y.tolist(),
            "y_unit": "1",
            "ci95": np.stack([Y - 0.03, Y + 0.03], axis=1).tolist(),
            "visited": {"edges": edges.tolist(), "share": [1.0 / 40.0] * 40},
        },
    }
    return diagnosis


@pytest.mark.parametrize("width", [style.WIDE, style.NARROW])
def test_the_curve_stands_above_what_was_visited(learned, width):
    figure = figures.law.draw(learned, width=width)
    top, below = figure.axes
    np.testing.assert_allclose(top.lines[0].get_ydata(), Y)
    assert below.get_xlabel() == "φ1 [rad]"
    assert figures.law.draw(learned, 1) is None


def test_no_curve_no_figure(made):
    assert figures.law.draw(made("explained")) is None
    assert pictures.learned(DiagnosisRecord.read(made("explained"))) == []


def test_the_page_and_the_text_say_it(learned):
    page, text = render(learned), summary(learned)
    assert "law-1" in page
    assert "0.4 cos 3 φ1" in page
    assert "bearing_dry.phi1" in text
    assert "a curve from -0.202 to 0.400" in text.replace("−", "-")


def test_a_family_is_a_clause():
    said = words.effect("bearing_dry.phi1")
    assert said.startswith("the bearing's dry friction changes with the column's angle")
    curve = Curve(x=(0.0, 1.0), y=(0.0, 1.0), y_unit="rad")
    assert verdict.sizes(Cause("bearing_dry.phi1", curve=curve)) == ["a curve from 0 to 1.00 rad"]
