"""Figures are drawn without pyplot, at every width, from whatever there is."""

import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from matplotlib import image
from matplotlib.figure import Figure

from tests.report.conftest import KINDS
from tp_jax.report import figures, style, write_report
from tp_jax.report.figures.curves import curves_of
from tp_jax.results.diagnosis import DiagnosisRecord, HeldOutRun

DRAW = {
    "free_run": figures.free_run.draw,
    "close_up": figures.free_run.close_up,
    "residuals": figures.residuals.draw,
    "state_map": figures.state_map.draw,
    "moved": figures.moved.draw,
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


def test_a_file_is_on_white_and_a_page_shows_its_own_ground(made, tmp_path):
    figure = DRAW["gap"](made("explained"))
    style.save(figure, tmp_path / "gap.png")
    assert (image.imread(tmp_path / "gap.png")[0, 0] == 1.0).all()  # opaque
    assert style.markup(figure).count("fill: #ffffff") == 1
    assert "#ffffff" not in style.svg(figure, "f", "what it shows")


def test_a_single_pendulum_has_one_channel(made):
    assert len(figures.free_run.draw(made("single")).axes) == 2
    assert len(figures.residuals.draw(made("single")).axes) == 1
    assert len(figures.free_run.draw(made("explained")).axes) == 4


def test_the_map_finds_where_the_model_misses(made):
    """Residuals that grow with a positive angle are largest there, and gone after."""
    diagnosis = made("explained")
    curve = diagnosis["curves"][0]["phi1"]["measured"]
    diagnosis["residuals"][0]["phi1"] = {
        "before": [9.0 if y > 0.15 else 0.5 for y in curve],
        "after": [0.5] * len(curve),
    }
    row = figures.state_map.points(DiagnosisRecord.read(diagnosis))[0]
    assert row.channel == "phi1"
    said = figures.state_map.described(DiagnosisRecord.read(diagnosis))
    angle = float(said.split("φ1 near ")[1].split(" rad")[0])
    assert angle > 0.12  # the middle of a cell that reaches up from 0.15
    assert "(9 times the noise)" in said


def test_the_map_takes_velocities_from_the_measured_angle(made):
    diagnosis = made("explained")
    t = diagnosis["curves"][0]["t"]
    diagnosis["curves"][0]["phi1"]["measured"] = [math.sin(6.3 * s) for s in t]
    row = figures.state_map.points(DiagnosisRecord.read(diagnosis))[0]
    assert max(row.velocity) == pytest.approx(6.3, rel=0.01)


def test_a_rider_that_winds_on_is_mapped_within_a_turn(made):
    diagnosis = made("explained")
    t = diagnosis["curves"][0]["t"]
    diagnosis["curves"][0]["phi2"]["measured"] = [9.0 * s for s in t]
    row = figures.state_map.points(DiagnosisRecord.read(diagnosis))[1]
    assert -math.pi <= min(row.angle) < max(row.angle) <= math.pi


def test_sparse_points_are_not_joined(made):
    """A line through three points a period would be a motion that never was."""
    diagnosis = made("explained")
    thin = figures.free_run.draw(diagnosis)
    entry = diagnosis["curves"][0]
    entry["t"] = [100.0 * s for s in entry["t"]]
    for channel in ("phi1", "phi2"):
        entry[channel] = {
            k: [math.sin(2.1 * i) for i in range(len(y))] for k, y in entry[channel].items()
        }
    sparse = figures.free_run.draw(diagnosis)
    joined = [line for line in sparse.axes[0].lines if len(line.get_xdata()) > 1]
    assert not joined
    assert len(sparse.axes[0].patches) == 3
    assert len([line for line in thin.axes[0].lines if len(line.get_xdata()) > 1]) == 3
    text = style.svg(sparse, "f", "x")
    assert len(text) < 400_000


def test_figures_are_saved_beside_the_report(made, tmp_path):
    report = tmp_path / "report.html"
    write_report(made("explained"), report, figures=True)
    folder = tmp_path / "figures"
    names = {path.name for path in folder.iterdir()}
    stems = {"first", "run-1", "residuals-1", "state-map", "where", "candidates", "moved"}
    assert names == {f"{stem}.{kind}" for stem in stems for kind in ("png", "svg")}
    assert (folder / "first.png").read_bytes().startswith(b"\x89PNG")
    assert "<svg" in (folder / "first.svg").read_text(encoding="utf-8")


def test_figures_of_an_earlier_report_go_and_nothing_else(made, tmp_path):
    folder = tmp_path / "figures"
    folder.mkdir()
    for name in ("run-7.png", "mine.png", "run-7.txt"):
        (folder / name).write_text("x")
    write_report(made("no_gap"), tmp_path / "report.html", figures=True)
    names = {path.name for path in folder.iterdir()}
    assert "run-7.png" not in names
    assert "moved.png" not in names
    assert {"mine.png", "run-7.txt", "run-1.png"} <= names


def test_the_report_is_the_only_file_unless_more_is_asked_for(made, tmp_path):
    write_report(made("explained"), tmp_path / "report.html")
    assert [path.name for path in tmp_path.iterdir()] == ["report.html"]


@pytest.mark.parametrize("name", list(DRAW))
def test_margins_are_not_left_to_matplotlib(made, name):
    """Its layout takes longer than the drawing."""
    assert DRAW[name](made("explained")).get_layout_engine() is None


def long_and_large() -> dict:
    """A diagnosis with names longer than fit, and numbers of many digits."""
    diagnosis = KINDS["explained"]()
    diagnosis["candidates"][0] |= {"effect": "m" * 90, "realised_shrink": -50.0}
    diagnosis["where"][0]["location"] = "m" * 90
    diagnosis["absorbed"] |= {
        "m" * 90: {"in_standard_errors": 123456.0},
        "b": {"in_standard_errors": -123456.0},
    }
    diagnosis["gap"]["before"]["free_run"] = 12345.0
    for key in ("curves", "residuals"):
        phi2 = diagnosis[key][0]["phi2"]
        phi2["before"] = [1e4 * y for y in phi2["before"]]
    return diagnosis


@pytest.mark.parametrize("width", [style.WIDE, style.NARROW])
@pytest.mark.parametrize("kind", ["explained", "long"])
@pytest.mark.parametrize("name", list(DRAW))
def test_no_text_is_cut_off_or_lies_on_another(name, kind, width):
    figure = DRAW[name](long_and_large() if kind == "long" else KINDS[kind](), width=width)
    figure.canvas.draw()
    page = figure.bbox
    for axes in figure.axes:
        labels = [axes.xaxis.label, axes.yaxis.label]
        for text in (*labels, *axes.texts, axes.title, *axes.get_yticklabels()):
            box = text.get_window_extent()
            low, high = sorted(axes.get_ylim())
            of_tick = text in axes.get_yticklabels()
            if text.get_text() and (not of_tick or low <= text.get_position()[1] <= high):
                assert box.x0 >= -1.0, text.get_text()
                assert box.x1 <= page.x1 + 1.0, text.get_text()
                assert box.y0 >= -1.0, text.get_text()
                assert box.y1 <= page.y1 + 1.0, text.get_text()
        label = axes.yaxis.label.get_window_extent()
        ticks = [text.get_window_extent() for text in axes.get_yticklabels() if text.get_text()]
        if axes.yaxis.label.get_text() and axes.yaxis.get_label_position() == "left":
            assert not any(label.overlaps(tick) for tick in ticks if axes.yaxis.get_visible())


def test_gaps_in_curves_are_drawn_over(made):
    diagnosis = made("explained")
    phi1 = diagnosis["curves"][0]["phi1"]
    phi1["before"] = [None] * 599 + [1.0]
    phi1["measured"][-1] = None
    phi1["after"] = [1.0]  # of another length: left out
    for name in ("free_run", "close_up"):
        style.svg(DRAW[name](diagnosis), "f", "x")


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


def test_a_number_over_which_no_axis_can_be_drawn_breaks_the_curve():
    entry = {"t": [0.0, 1.0, 2.0], "phi1": {"measured": [0.1, 1e308, 0.2]}}
    (curve,) = curves_of(HeldOutRun.read(entry))
    assert np.isnan(curve.measured).tolist() == [False, True, False]
    assert curves_of(HeldOutRun.read(entry | {"t": [1e300, 1e301, 1e302]})) == []
