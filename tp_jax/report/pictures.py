"""The figures of the page: which there are, in two widths, with their captions."""

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from tp_jax.report import captions, style
from tp_jax.report.figures import candidates, free_run, gap, law, moved, residuals, state_map, where
from tp_jax.report.figures.curves import drawable
from tp_jax.results.diagnosis import DiagnosisRecord

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Recordings drawn; more would make the page heavy without saying more.
MOST_RECORDINGS = 3


class Picture(NamedTuple):
    """A figure in two widths, as `<svg>` elements, its caption, the wide one and its SVG file."""

    name: str
    wide: str
    narrow: str
    caption: str
    figure: "Figure"
    file: str


class Pictures(NamedTuple):
    """All figures of a page; what there is nothing to draw of is None or missing."""

    first: Picture | None
    runs: list[Picture]
    windows: list[Picture]
    state_map: Picture | None
    places: Picture | None
    laws: list[Picture]
    bars: Picture | None
    moved: Picture | None

    def every(self) -> list[Picture]:
        """One after the other, as in the page."""
        found = (
            self.first,
            *self.runs,
            *self.windows,
            self.state_map,
            self.places,
            *self.laws,
            self.bars,
            self.moved,
        )
        return [one for one in found if one is not None]


def pictures(diagnosis: DiagnosisRecord) -> Pictures:
    """Draws everything."""
    return Pictures(
        first(diagnosis),
        runs(diagnosis),
        windows(diagnosis),
        over_states(diagnosis),
        places(diagnosis),
        learned(diagnosis),
        bars(diagnosis),
        shifts(diagnosis),
    )


def picture(
    draw: Callable[[float], "Figure | None"], name: str, caption: str, width: float = style.WIDE
) -> Picture | None:
    """The figure for wide pages and for phones; None if there is nothing to draw.

    Args:
        draw: makes the figure from its width in inches.
        name: unique in the page, and the name of its files.
        caption: also the figure's text for those who do not see it.
        width: in inches, on wide pages.
    """
    wide, narrow = draw(width), draw(style.NARROW)
    if wide is None or narrow is None:
        return None
    file = style.markup(wide)
    return Picture(
        name,
        style.inline(file, f"{name}-w", caption),
        style.svg(narrow, f"{name}-n", caption),
        caption,
        wide,
        file,
    )


def first(diagnosis: DiagnosisRecord) -> Picture | None:
    """The picture beside the verdict."""
    order = [_close_up, _gap, _where]
    if diagnosis.verdict in ("unknown", None):
        order = [_where, _close_up, _gap]
    for draw in order:
        found = draw(diagnosis, style.BESIDE, "first")
        if found is not None:
            return found
    return None


def runs(diagnosis: DiagnosisRecord) -> list[Picture]:
    """Free runs over held-out recordings; the bare errors where there are no curves."""
    many = len(drawable(diagnosis.curves)[:MOST_RECORDINGS])
    found = _several(diagnosis, free_run.draw, "run", captions.run, many)
    if not many:
        gap_alone = _gap(diagnosis, style.WIDE, "gap")
        found += [] if gap_alone is None else [gap_alone]
    return found


def windows(diagnosis: DiagnosisRecord) -> list[Picture]:
    """Windowed residuals over time."""
    many = len(drawable(diagnosis.residuals)[:MOST_RECORDINGS])
    return _several(diagnosis, residuals.draw, "residuals", captions.windows, many)


def over_states(diagnosis: DiagnosisRecord) -> Picture | None:
    """Windowed residuals over angle and velocity."""
    caption = captions.over_states(diagnosis)
    return picture(lambda width: state_map.draw(diagnosis, width), "state-map", caption)


def places(diagnosis: DiagnosisRecord) -> Picture | None:
    """Draws where the gap lies, unless it stands beside the verdict or would be a single bar."""
    if diagnosis.verdict in ("unknown", None) or len(where.shown(diagnosis)) < 2:
        return None
    return _where(diagnosis, style.WIDE, "where")


def learned(diagnosis: DiagnosisRecord) -> list[Picture]:
    """Curves of causes that nobody wrote down."""
    return _several(diagnosis, law.draw, "law", captions.law, len(law.shown(diagnosis)))


def bars(diagnosis: DiagnosisRecord) -> Picture | None:
    """The candidates."""
    caption = captions.candidates(diagnosis)
    return picture(lambda width: candidates.draw(diagnosis, width), "candidates", caption)


def shifts(diagnosis: DiagnosisRecord) -> Picture | None:
    """Draws what moved when the causes were added."""
    caption = captions.moved(diagnosis)
    return picture(lambda width: moved.draw(diagnosis, width), "moved", caption)


def _several(
    diagnosis: DiagnosisRecord,
    draw: Callable[..., "Figure | None"],
    name: str,
    caption: Callable[[DiagnosisRecord, int], str],
    many: int,
) -> list[Picture]:
    """The first figures of a kind, numbered from one; those that have something to show."""
    found = [
        picture(
            lambda width, i=i: draw(diagnosis, i, width), f"{name}-{i + 1}", caption(diagnosis, i)
        )
        for i in range(many)
    ]
    return [drawn for drawn in found if drawn is not None]


def _close_up(diagnosis: DiagnosisRecord, width: float, name: str) -> Picture | None:
    caption = captions.close_up(diagnosis)
    return picture(lambda w: free_run.close_up(diagnosis, w), name, caption, width)


def _where(diagnosis: DiagnosisRecord, width: float, name: str) -> Picture | None:
    return picture(lambda w: where.draw(diagnosis, w), name, captions.where(diagnosis), width)


def _gap(diagnosis: DiagnosisRecord, width: float, name: str) -> Picture | None:
    return picture(lambda w: gap.draw(diagnosis, w), name, captions.GAP, width)
