"""The figures, in one style and in colours that can be told apart without seeing all of them."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from tp_jax.cli.output import replaced

from .alone import FEW
from .rows import BARS, duration, smoothing

# Okabe and Ito's palette, a dark red instead of its yellow, and a grey
COLOURS = (
    "#D55E00",
    "#000000",
    "#0072B2",
    "#56B4E9",
    "#009E73",
    "#CC79A7",
    "#E69F00",
    "#999999",
    "#882255",
)
MARKERS = "osD^vPX*<"
STYLE = {
    "figure.figsize": (7.0, 4.6),
    "figure.dpi": 150,
    "font.size": 10,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "legend.fontsize": 8,
}


def draw(measures: Mapping[str, Any], names: list[str], folder: Path) -> list[Path]:
    """Draws what was measured; `names` are the peers, ours first. Returns the files."""
    import matplotlib

    matplotlib.use("agg")
    from matplotlib import pyplot as plt

    looks = {
        name: {"color": COLOURS[i % len(COLOURS)], "marker": MARKERS[i % len(MARKERS)]}
        for i, name in enumerate(names)
    }
    written = []
    with plt.rc_context(STYLE):
        for stem, figure in _figures(plt, measures, looks):
            path = folder / f"{stem}.png"
            figure.tight_layout()
            with replaced(path) as part:
                figure.savefig(part)
            plt.close(figure)
            written.append(path)
    return written


def _figures(plt: Any, measures: Mapping[str, Any], looks: Mapping) -> Iterator[tuple[str, Any]]:
    curves = measures.get("precision", {}).get("curves", [])
    for eps in dict.fromkeys(curve["eps"] for curve in curves):
        chosen = [c for c in curves if c["eps"] == eps and c["points"]]
        yield f"precision-eps-{eps:g}", _precision(plt, chosen, looks, eps)
    for measure, label in (("single", "one run"), ("sweep", "a run of a sweep")):
        results = measures.get(measure, {}).get("results", [])
        for eps in dict.fromkeys(one["eps"] for one in results):
            chosen = [one for one in results if one["eps"] == eps]
            yield f"{measure}-eps-{eps:g}", _bars(plt, chosen, looks, label, eps)
    scaling = measures.get("scaling", {}).get("results", [])
    if scaling:
        yield "scaling", _scaling(plt, scaling, next(iter(looks.values())))


def _precision(plt: Any, curves: list, looks: Mapping, eps: float) -> Any:
    figure, axes = plt.subplots()
    for curve in curves:
        points = curve["points"]
        x, y = [1e3 * p["seconds"] for p in points], [p["error"] for p in points]
        axes.loglog(x, y, label=curve["peer"], linewidth=1.2, markersize=4, **looks[curve["peer"]])
    axes.set(
        xlabel="one run [ms]",
        ylabel="largest error of an angle [rad]",
        title=f"Error against cost, {smoothing(eps)}",
    )
    axes.legend()
    return figure


def _bars(plt: Any, results: list, looks: Mapping, label: str, eps: float) -> Any:
    figure, axes = plt.subplots()
    ordered = sorted(results, key=lambda one: -one["seconds"]["median"])
    for one in ordered:
        s = {name: 1e3 * value for name, value in one["seconds"].items()}
        spread = [[s["median"] - s["low"]], [s["high"] - s["median"]]]
        axes.barh(
            one["peer"], s["median"], xerr=spread, color=looks[one["peer"]]["color"], height=0.7
        )
        words = f"  {duration(one['seconds']['median'])}"
        axes.annotate(words, (s["high"], one["peer"]), va="center", fontsize=8)
    # room on the left, since a bar on a logarithmic axis begins nowhere
    left = 0.3e3 * min(one["seconds"]["low"] for one in ordered)
    right = 4e3 * max(one["seconds"]["high"] for one in ordered)
    axes.set(xscale="log", xlim=(left, right))
    axes.set(xlabel=f"{label} [ms], error up to 1e-5 rad or the best", title=smoothing(eps))
    axes.grid(axis="y", visible=False)
    return figure


def _scaling(plt: Any, results: list, look: Mapping) -> Any:
    figure, (left, right) = plt.subplots(1, 2)
    lanes = [one["lanes"] for one in results]
    over = [one["over_few"] for one in results]
    medians = [o["median"] for o in over]
    spread = [
        [o["median"] - o["low"] for o in over],
        [o["high"] - o["median"] for o in over],
    ]
    left.errorbar(lanes, medians, yerr=spread, **look)
    left.axhline(BARS["scaling"][1], color="black", linewidth=0.8, linestyle="--")
    left.set(xscale="log", xlabel="lanes", title=f"Cost of a lane, over that of {FEW}")
    left.set_ylim(0.0, 1.15 * max(BARS["scaling"][1], *(o["high"] for o in over)))
    # few lanes fit into what the program itself once took
    seen = [one for one in results if one["bytes_per_lane"] > one["bytes_of_angles"]]
    for key, style, name in (
        ("bytes_per_lane", {"label": "all"}, "-"),
        ("bytes_of_angles", {"label": "angles alone", "marker": ""}, ":"),
    ):
        x = [one["lanes"] for one in seen]
        y = [one["lanes"] * one[key] / 1e6 for one in seen]
        right.loglog(x, y, **{**look, "linestyle": name, **style})
    right.set(xlabel="lanes", title="Memory [MB]")
    if seen:
        right.legend()
    return figure
