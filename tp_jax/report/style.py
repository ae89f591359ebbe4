"""One look for all figures: colours, sizes, and figures as SVG that stands inside a page.

The colours are Okabe and Ito's, which people with any of the common colour blindnesses can tell
apart. In a page they become CSS variables, so that its style sheet can choose lighter ones on a
dark screen; text and axes take the colour of the page's text.
"""

import html
import io
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from tp_jax.report.layout import FONT_SIZE, SPACING

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INK = "#1b1f24"
MUTED = "#6e7781"
BEFORE = "#d55e00"  # vermillion
AFTER = "#0072b2"  # blue
BAND = "#8c959f"

#: Colour of a figure to what stands for it in a page.
PAGE_COLOURS = {
    INK: "currentColor",
    MUTED: "var(--muted)",
    BEFORE: "var(--before)",
    AFTER: "var(--after)",
    BAND: "var(--band)",
}

#: Widths in inches: beside the verdict, across a page, across a phone.
BESIDE, WIDE, NARROW = 5.4, 9.6, 3.7

#: Map of sizes whose light grows evenly, for any common colour blindness.
SCALE = "cividis"

SMALL = FONT_SIZE - 1.5
"""Points, of the numbers at bars that stand close together."""

_SETTINGS: dict[Any, Any] = {
    "svg.fonttype": "none",  # text stays text
    "svg.hashsalt": "tp-jax",  # the same figure, the same bytes
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "axes.unicode_minus": True,
}
_NO_METADATA = {"Date": None, "Creator": None, "Format": None, "Type": None}

PIXELS = 150  # per inch, of figures saved as PNG


def new_figure(width: float, height: float, *, fitted: bool = False) -> "Figure":
    """An empty figure of its own, no part of pyplot, on a transparent background.

    Args:
        width, height: in inches.
        fitted: whether matplotlib finds the margins, which takes longer than the drawing;
            otherwise `layout.place` sets them.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained" if fitted else None)
    FigureCanvasAgg(figure)
    figure.patch.set_alpha(0.0)
    return figure


def dress(axes: "Axes", *, grid: Literal["x", "y"] | None = "y") -> None:
    """Quiet axes: no box, thin grid lines along `grid` ("x", "y" or None)."""
    axes.patch.set_alpha(0.0)
    for side in ("top", "right", "left", "bottom"):
        axes.spines[side].set_visible(False)
    axes.tick_params(labelsize=FONT_SIZE, labelcolor=INK, length=0.0)
    axes.xaxis.label.set(size=FONT_SIZE, color=INK)
    axes.yaxis.label.set(size=FONT_SIZE, color=INK)
    axes.set_axisbelow(True)
    if grid:
        axes.grid(axis=grid, color=BAND, lw=0.6, alpha=0.35)


def dots(axes: "Axes", t: Any, y: Any, *, color: str, size: float, label: str = "") -> None:
    """Points (n,) at times (n,), as one path: a tenth of what a mark for each takes in a page.

    Args:
        size: diameter in points.
        label: for the legend.
    """
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    whole = np.isfinite(y)
    t, y = np.asarray(t)[whole], np.asarray(y)[whole]
    if not t.size:
        return
    short = 1e-4 * (np.ptp(t) or 1.0)  # a stroke of no length would not be drawn everywhere
    ends = np.stack([np.stack([t, y], -1), np.stack([t + short, y], -1)], axis=1).reshape(-1, 2)
    path = Path(ends, np.tile([Path.MOVETO, Path.LINETO], t.size))
    path.should_simplify = False
    axes.add_patch(PathPatch(path, fill=False, ec=color, lw=size, capstyle="round"))
    axes.update_datalim(ends)
    axes.autoscale_view()
    axes.plot([], [], color=color, ls="", marker="o", ms=max(size, 3.0), mew=0.0, label=label)


def title(axes: "Axes", text: str) -> None:
    """A short title at the left."""
    # a name of a file may hold dollar signs, which are no mathematics
    font: dict[str, Any] = {"fontsize": FONT_SIZE + 0.5, "fontweight": "bold"}
    axes.set_title(text, loc="left", color=INK, parse_math=False, **font)


def legend(figure: "Figure", *axes: "Axes") -> float:
    """The labels of these axes above the figure, each once; on phones in two columns.

    Returns:
        The height it takes, in inches.
    """
    columns = 4 if figure.get_figwidth() >= BESIDE else 2
    found: dict[str, Any] = {}
    for one in axes:
        handles, labels = one.get_legend_handles_labels()
        found |= dict(zip(labels, handles, strict=True))
    looks: dict[str, Any] = dict(loc="outside upper left")
    if figure.get_layout_engine() is None:
        width, height = figure.get_size_inches()
        corner = SPACING.edge / width, 1.0 - SPACING.edge / height
        looks = dict(loc="upper left", bbox_to_anchor=corner, borderaxespad=0.0, borderpad=0.0)
    figure.legend(
        list(found.values()),
        list(found),
        ncols=columns,
        frameon=False,
        fontsize=FONT_SIZE,
        labelcolor=INK,
        handlelength=1.6,
        columnspacing=1.4,
        **looks,
    )
    return -(-len(found) // columns) * SPACING.line + SPACING.pad


def save(figure: "Figure", path: Path) -> None:
    """The figure as a file of its own, on white; PNG or SVG, as the path's suffix says."""
    kind = path.suffix.removeprefix(".")
    with path.open("wb") as stream:
        _write(figure, stream, kind)


def markup(figure: "Figure") -> str:
    """The figure as an SVG file's text, on white."""
    stream = io.BytesIO()
    _write(figure, stream, "svg")
    return stream.getvalue().decode()


def _write(figure: "Figure", stream: io.BufferedIOBase, kind: str) -> None:
    """Draws it, once, where `savefig` draws twice.

    A figure keeps the layout of the first time, which takes as long as drawing.
    """
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    figure.patch.set(alpha=1.0, facecolor="white")
    figure.dpi = PIXELS
    with matplotlib.rc_context(_SETTINGS):
        if kind == "svg":
            FigureCanvasSVG(figure).print_svg(stream, metadata=_NO_METADATA)
        else:
            FigureCanvasAgg(figure).print_png(stream, metadata={"Software": None})
    figure.set_layout_engine("none")


def svg(figure: "Figure", name: str, label: str) -> str:
    """The figure as an `<svg>` element to stand inside an HTML page; see `inline`."""
    return inline(markup(figure), name, label)


def inline(text: str, name: str, label: str) -> str:
    """A figure's SVG file as an `<svg>` element to stand inside an HTML page, on its ground.

    Args:
        text: of the file; see `markup`.
        name: prefix of its ids, which must be unique in the page.
        label: what it shows, in words, for those who do not see it.
    """
    box = re.search(r'viewBox="([^"]+)"', text)
    body = text[text.index(">", text.index("<svg")) + 1 :]
    body = re.sub(r"<metadata>.*?</metadata>", "", body, flags=re.DOTALL)
    # this style would reach the whole page; it has its like in the page's style sheet
    body = re.sub(r"<defs>\s*<style[^>]*>.*?</style>\s*</defs>", "", body, flags=re.DOTALL)
    body = re.sub(r"<!--.*?-->\s*", "", body, flags=re.DOTALL)
    # the figure's white ground, and those of axes, which are not seen
    body = re.sub(r'<g id="patch_1">.*?</g>', "", body, count=1, flags=re.DOTALL)
    body = re.sub(r'<g id="patch_\d+">\s*<path [^>]*opacity: 0"/>\s*</g>', "", body)
    body = _without_idle_ids(body)
    body = re.sub(r'\bid="', f'id="{name}-', body)
    body = body.replace("url(#", f"url(#{name}-").replace('xlink:href="#', f'href="#{name}-')
    body = re.sub(r"(font: [^;\"]*?px) [^;\"]*", r"\1 system-ui, sans-serif", body)
    body = re.sub(r"-?\d+\.\d{3,}", _shorter, body)
    for colour, variable in PAGE_COLOURS.items():
        body = body.replace(colour, variable)
    body = re.sub(r"\n\s*", "\n", body)
    frame = "" if box is None else f' viewBox="{box.group(1)}"'
    return f'<svg role="img" aria-label="{html.escape(label)}"{frame}>{body.strip()}'


def _without_idle_ids(body: str) -> str:
    """The markup without the ids that nothing refers to; equal images have equal ones."""
    used = set(re.findall(r'(?:url\(#|href="#)([^)"]+)', body))
    return re.sub(
        r' id="([^"]*)"', lambda found: found.group() if found.group(1) in used else "", body
    )


def _shorter(found: re.Match[str]) -> str:
    """A coordinate to hundredths of a point."""
    return f"{float(found.group()):.2f}".rstrip("0").rstrip(".")
