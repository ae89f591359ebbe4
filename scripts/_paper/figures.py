"""The paper's figures again, and what they do not show."""

from pathlib import Path
from typing import Any

import numpy as np

from scripts._paper import section_5_2
from scripts._paper.objective import ORDER, motion, of_preset
from scripts._paper.scale import Scale
from scripts._paper.truth import OMEGA
from tp_jax.model import presets
from tp_jax.report import style
from tp_jax.simulation.solve import accelerations, simulate

COLOURS = {
    "Nelder-Mead, 50 iterations": style.BAND,
    "Nelder-Mead, thousands": style.BEFORE,
    "gradients, whole run": "#009e73",
    "gradients, windows": style.AFTER,
}
LEAST = 1e-20  # rad^2; a y below is rounding


def draw(result: dict[str, Any], scale: Scale, folder: Path) -> list[Path]:
    """All figures as PNG."""
    drawn = {
        "figure-09": _figure_9(scale),
        "figure-10": _figure_10(result, scale),
        "figure-11": _figure_11(result, scale),
        "figure-12": _measured(result, scale, 0),
        "figure-13": _measured(result, scale, 1),
        "progress": _progress(result),
        "what-y-sees": _seen(result),
        "no-slip": _no_slip(scale),
    }
    paths = []
    for name, figure in drawn.items():
        path = folder / f"{name}.png"
        style.save(figure, path)
        paths.append(path)
    return paths


def _legend(figure, axes, columns: int = 4) -> None:
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(
        handles,
        labels,
        loc="outside upper left",
        ncols=columns,
        frameon=False,
        fontsize=style.FONT_SIZE,
        labelcolor=style.INK,
    )


def _figure_9(scale: Scale):
    """Angles, velocities and accelerations of Section 5.1."""
    model = presets.get("paper-5.1")
    m = simulate(model, scale.ts)
    column, rider = accelerations(model, m)
    rows = (
        ("angle [rad]", m.phi1, m.phi2),
        ("velocity [rad/s]", m.omega1, m.omega2),
        ("acceleration [rad/s²]", column, rider),
    )
    figure = style.new_figure(style.WIDE, 6.0)
    grid = figure.subplots(3, 2, sharex=True)
    for (label, one, two), line in zip(rows, grid, strict=True):
        for y, axes in zip((one, two), line, strict=True):
            style.dress(axes)
            axes.plot(scale.ts, np.asarray(y), color=style.AFTER, lw=1.2)
            axes.margins(x=0.0)
        line[0].set_ylabel(label)
    style.title(grid[0, 0], "column, φ1")
    style.title(grid[0, 1], "rider, φ2: it creeps, it never slips")
    for axes in grid[-1]:
        axes.set_xlabel("time [s]")
    return figure


def _runs_of(result: dict[str, Any], methods: dict[str, str], scale: Scale, title: str):
    """Angles of Section 5.1's printed run, actual and by some methods."""
    truth = motion(of_preset("paper-5.1"), OMEGA, scale.ts)
    found = {row["method"]: row["x"] for row in result["section_5_1"]["runs"]["printed"]["methods"]}
    found["start"] = dict(zip(ORDER, result["section_5_1"]["start"], strict=True))
    figure = style.new_figure(style.WIDE, 4.6)
    grid = figure.subplots(2, 1, sharex=True)
    for channel, label, axes in zip(("phi1", "phi2"), ("φ1", "φ2"), grid, strict=True):
        style.dress(axes)
        axes.plot(
            scale.ts,
            np.asarray(getattr(truth, channel)),
            color=style.BAND,
            lw=4.0,
            alpha=0.7,
            label="actual",
        )
        for name, colour in methods.items():
            m = motion([found[name][n] for n in ORDER], OMEGA, scale.ts)
            axes.plot(scale.ts, np.asarray(getattr(m, channel)), color=colour, lw=1.2, label=name)
        axes.set_ylabel(f"{label} [rad]")
        axes.margins(x=0.0)
    style.title(grid[0], title)
    grid[-1].set_xlabel("time [s]")
    _legend(figure, grid[0])
    return figure


def _figure_10(result, scale):
    methods = {"start": style.BEFORE, "Nelder-Mead, 50 iterations": style.AFTER}
    return _runs_of(result, methods, scale, "before the search has ended")


def _figure_11(result, scale):
    methods = {"Nelder-Mead, thousands": style.BEFORE, "gradients, windows": style.AFTER}
    return _runs_of(result, methods, scale, "when it has ended")


def _measured(result, scale: Scale, which: int):
    """The virtual rig against the printed model, as in Figs. 12 and 13."""
    objective = section_5_2.measured(scale)[which]
    entry = result["section_5_2"]["identifications"][which]
    figure = style.new_figure(style.WIDE, 4.6)
    grid = figure.subplots(2, 1, sharex=True)
    runs = {
        f"Nelder-Mead, y = {entry['nelder_mead']['y']:.4g}": ("nelder_mead", style.BEFORE),
        f"windows, y = {entry['windows']['y']:.4g}": ("windows", style.AFTER),
    }
    for channel, label, axes in zip(("phi1", "phi2"), ("φ1", "φ2"), grid, strict=True):
        style.dress(axes)
        axes.plot(
            objective.ts,
            getattr(objective, channel),
            color=style.BAND,
            lw=4.0,
            alpha=0.7,
            label="measured (virtual rig)",
        )
        for name, (key, colour) in runs.items():
            m = motion([entry[key]["x"][n] for n in ORDER], objective.omega, objective.ts)
            axes.plot(
                objective.ts, np.asarray(getattr(m, channel)), color=colour, lw=1.0, label=name
            )
        axes.set_ylabel(f"{label} [rad]")
        axes.margins(x=0.0)
    style.title(
        grid[0], f"identification {which + 1}; the paper's ended at y = {section_5_2.PAPER[which]}"
    )
    grid[-1].set_xlabel("time [s]")
    _legend(figure, grid[0])
    return figure


def _progress(result):
    """y by evaluation: the picture Listing 1 draws while it searches."""
    figure = style.new_figure(style.WIDE, 3.8)
    grid = figure.subplots(1, 2, sharey=True)
    titles = {"printed": "ω = 0.5 rad/s, as printed", "slipping": "ω = 2.1 rad/s: the rider slips"}
    for (key, title), axes in zip(titles.items(), grid, strict=True):
        style.dress(axes)
        run = result["section_5_1"]["runs"][key]
        for row in run["methods"]:
            colour = COLOURS[row["method"]]
            if row["history"]["y"]:
                axes.plot(
                    row["history"]["evaluation"],
                    np.maximum(row["history"]["y"], LEAST),
                    color=colour,
                    lw=1.4,
                    label=row["method"],
                )
            axes.plot(
                row["evaluations"],
                max(row["y"], LEAST),
                marker="o",
                ms=6,
                mew=0.0,
                color=colour,
                ls="",
                label=None if row["history"]["y"] else row["method"],
            )
        axes.set(xscale="log", yscale="log")
        axes.set_xlabel("evaluations of the whole recording")
        style.title(axes, title)
    grid[0].set_ylabel("y of (17) [rad²]")
    _legend(figure, grid[0])
    return figure


def _seen(result):
    """Draws what ten per cent of a parameter do to y."""
    seen = result["seen"]
    figure = style.new_figure(style.WIDE, 4.4)
    grid = figure.subplots(1, 2, sharey=True)
    titles = {"printed": "ω = 0.5 rad/s, as printed", "slipping": "ω = 2.1 rad/s: the rider slips"}
    for (key, title), axes in zip(titles.items(), grid, strict=True):
        style.dress(axes, grid="x")
        y = seen[key]["y"]
        sizes = [max(y[n] or 0.0, LEAST) for n in ORDER]
        clear = [s > seen["detectable"] for s in sizes]
        axes.barh(
            range(len(ORDER)),
            sizes,
            height=0.66,
            lw=0.0,
            color=[style.AFTER if c else style.BAND for c in clear],
        )
        axes.axvline(seen["detectable"], color=style.INK, lw=1.0, ls=(0, (2, 2)))
        for i, n in enumerate(ORDER):
            if not y[n]:
                axes.annotate(
                    "0",
                    (LEAST, i),
                    (4, 0),
                    textcoords="offset points",
                    va="center",
                    fontsize=style.FONT_SIZE,
                    color=style.INK,
                )
        axes.set(xscale="log", xlim=(LEAST, 1.0))
        axes.set_yticks(range(len(ORDER)), ORDER)
        axes.set_xlabel("y of (17) for 10 % [rad²]; dashed: seen in noise of 1 mrad")
        style.title(axes, title)
    grid[0].invert_yaxis()
    return figure


def _no_slip(scale: Scale):
    """The contact's torque against what it takes to slip, and the creep that smoothing makes."""
    values = presets.values("paper-5.1")
    figure = style.new_figure(style.WIDE, 4.6)
    torque, angle = figure.subplots(2, 1, sharex=True)
    for axes in (torque, angle):
        style.dress(axes)
    for eps, colour in ((values["eps"], style.BEFORE), (100.0 * values["eps"], style.AFTER)):
        model = presets.double_pendulum(**{**values, "eps": eps})
        m = simulate(model, scale.ts, tolerance=1e-9)
        found = model.motion(m.t, (m.phi1, m.phi2, m.omega1, m.omega2)).contact
        label = f"ε = {eps:.0e} s".replace("e+0", "e")
        torque.plot(scale.ts, np.asarray(found), color=colour, lw=1.2, label=label)
        angle.plot(scale.ts, 1e3 * np.asarray(m.phi2), color=colour, lw=1.2)
    torque.margins(x=0.0)
    for sign in (-1.0, 1.0):
        torque.axhline(sign * values["Ts1"], color=style.INK, lw=1.0, ls=(0, (2, 2)))
    torque.set_ylabel("M_T [N m]; dashed: ±Ts1")
    angle.set_ylabel("φ2 [mrad]")
    angle.set_xlabel("time [s]")
    angle.margins(x=0.0)
    style.title(torque, "Section 5.1: the contact's torque never reaches what it takes to slip")
    _legend(figure, torque)
    return figure
