"""Figures are drawn without pyplot, at every width, from whatever there is."""

import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("matplotlib")

from matplotlib.figure import Figure

from tp_jax.report import figures, style

DRAW = {
    "free_run": figures.free_run.draw,
    "close_up": figures.free_run.close_up,
    "residuals": figures.residuals.draw,
    "candidates": figures.candidates.draw,
    "where": figures.where.draw,
    "gap": figures.gap.draw,
}


@pytest.mark.parametrize("name", list(DRAW))
@pytest.mark.parametrize("width", [style.WIDE, style.BESIDE, style.NARROW])
def test_a_full_diagnosis_has_every_figure(made, name, width):
    figure = DRAW[name](made("explained"), width=width)
    assert isinstance(figure, Figure)
    assert figure.get_figwidth() == width
    assert style.svg(figure, "f", "what it shows").startswith('<svg role="img" aria-label="what')


@pytest.mark.parametrize("name", list(DRAW))
def test_any_diagnosis_draws_or_has_nothing(diagnosis, name):
    figure = DRAW[name](diagnosis)
    if figure is not None:
        style.svg(figure, "f", "x")


def test_a_single_pendulum_has_one_channel(made):
    assert len(figures.free_run.draw(made("single")).axes) == 2
    assert len(figures.residuals.draw(made("single")).axes) == 1
    assert len(figures.free_run.draw(made("explained")).axes) == 4


def test_gaps_in_curves_are_drawn_over(made):
    diagnosis = made("explained")
    phi1 = diagnosis["curves"][0]["phi1"]
    phi1["before"] = [None] * 599 + [1.0]
    phi1["measured"][-1] = None
    phi1["after"] = [1.0]  # of another length: left out
    for name in ("free_run", "close_up"):
        style.svg(DRAW[name](diagnosis), "f", "x")


def test_bars_keep_their_place_under_long_names_and_large_numbers(made):
    diagnosis = made("explained")
    diagnosis["candidates"][0] |= {"effect": "a" * 90, "realised_shrink": -50.0}
    diagnosis["where"][0]["location"] = "b" * 90
    for name in ("candidates", "where"):
        style.svg(DRAW[name](diagnosis, width=style.NARROW), "f", "x")


def test_colours_follow_the_page(made):
    text = style.svg(figures.free_run.draw(made("explained")), "f", "x")
    assert "var(--before)" in text
    assert "var(--after)" in text
    assert "currentColor" in text
    assert style.BEFORE not in text
    assert "<style" not in text
    assert "xmlns" not in text


def test_settings_are_left_as_they_were(made):
    import matplotlib

    before = dict(matplotlib.rcParams)
    style.svg(figures.where.draw(made("explained")), "f", "x")
    assert dict(matplotlib.rcParams) == before


@pytest.mark.parametrize("module", ["tp_jax.report", "tp_jax.report.html", "tp_jax.report.figures"])
def test_loads_neither_jax_nor_pyplot(module):
    code = (
        f"import {module}, sys; "
        "assert not {'jax', 'diffrax', 'matplotlib'} & set(sys.modules), 'loaded'"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=Path(__file__).parents[2])


def test_a_whole_report_needs_no_jax_and_no_pyplot(tmp_path):
    code = (
        "import sys; from tp_jax.report import summary, write_report; d = {'verdict': 'unknown', "
        "'where': [{'location': 'contact', 'share': 1.0}]}; "
        f"write_report(d, {str(tmp_path / 'r.html')!r}); summary(d); "
        "assert not {'jax', 'matplotlib.pyplot'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=Path(__file__).parents[2])
