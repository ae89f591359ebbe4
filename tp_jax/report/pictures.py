"""The figures of the page, with what each of them shows in words."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from tp_jax.report import reading, style, words
from tp_jax.report.figures import candidates, free_run, gap, residuals, where
from tp_jax.report.figures.curves import drawable
from tp_jax.report.formatting import percent

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Recordings drawn; more would make the page heavy without saying more.
MOST_RECORDINGS = 3


class Picture(NamedTuple):
    """A figure in two widths, as `<svg>` elements, and its caption."""

    name: str
    wide: str
    narrow: str
    caption: str


def picture(
    draw: Callable[[float], "Figure | None"], name: str, caption: str, width: float = style.WIDE
) -> Picture | None:
    """The figure for wide pages and for phones; None if there is nothing to draw.

    Args:
        draw: makes the figure from its width in inches.
        name: unique in the page.
        caption: also the figure's text for those who do not see it.
        width: in inches, on wide pages.
    """
    wide, narrow = draw(width), draw(style.NARROW)
    if wide is None or narrow is None:
        return None
    return Picture(
        name,
        style.svg(wide, f"{name}-w", caption),
        style.svg(narrow, f"{name}-n", caption),
        caption,
    )


def first(diagnosis: Mapping[str, Any]) -> Picture | None:
    """The picture beside the verdict."""
    choices = {"close_up": _close_up, "where": _where, "gap": _gap}
    order = ["close_up", "gap", "where"]
    if reading.verdict(diagnosis) == "unknown":
        order = ["where", "close_up", "gap"]
    for name in order:
        found = choices[name](diagnosis, style.BESIDE)
        if found is not None:
            return found
    return None


def runs(diagnosis: Mapping[str, Any]) -> list[Picture]:
    """Free runs over held-out recordings; the bare errors where there are no curves."""
    entries = drawable(diagnosis, "curves")[:MOST_RECORDINGS]
    found = []
    for i, entry in enumerate(entries):
        caption = (
            f"Free run over {_recording(entry)}, from its first moments on: {_run_words(entry)} "
            f"Below each angle, the model's error on a scale of its own; "
            f"{free_run.described(diagnosis, i)}."
        )
        found.append(picture(lambda w, i=i: free_run.draw(diagnosis, i, w), f"run{i}", caption))
    if not entries:
        found.append(_gap(diagnosis, style.WIDE))
    return [drawn for drawn in found if drawn is not None]


def windows(diagnosis: Mapping[str, Any]) -> list[Picture]:
    """Windowed residuals over time."""
    entries = drawable(diagnosis, "residuals")[:MOST_RECORDINGS]
    found = []
    for i, entry in enumerate(entries):
        caption = (
            f"Residuals over {_recording(entry)}, each window started anew. A complete model "
            f"leaves 95 % of them inside the grey band and no pattern; "
            f"{residuals.described(diagnosis, i)}."
        )
        found.append(
            picture(lambda w, i=i: residuals.draw(diagnosis, i, w), f"residuals{i}", caption)
        )
    return [drawn for drawn in found if drawn is not None]


def places(diagnosis: Mapping[str, Any]) -> Picture | None:
    """Where the gap lies."""
    return _where(diagnosis, style.WIDE)


def bars(diagnosis: Mapping[str, Any]) -> Picture | None:
    """The candidates."""
    rows = candidates.shown(diagnosis)
    caption = (
        f"The {len(rows)} most probable candidates, each added to the model alone. A long blue bar "
        "is an effect that removes the gap on data it was not fitted on; where it is much shorter "
        "than the grey one, the linear forecast was too hopeful. No blue bar: not refitted."
    )
    if reading.causes(diagnosis):
        caption += " Bold: accepted."
    return picture(lambda w: candidates.draw(diagnosis, w), "candidates", caption)


def _close_up(diagnosis: Mapping[str, Any], width: float) -> Picture | None:
    entries = drawable(diagnosis, "curves")
    if not entries:
        return None
    caption = f"The part of {_recording(entries[0])} where the model misses most: "
    caption += _run_words(entries[0])
    return picture(lambda w: free_run.close_up(diagnosis, w), "closeup", caption, width)


def _run_words(entry: Mapping[str, Any]) -> str:
    after = any(reading.table(entry, channel).get("after") for channel in reading.CHANNELS)
    if after:
        return (
            "the broad grey line is measured and was never fitted, the dashed line is the model "
            "before, the blue one the model after. The better the model, the closer it stays to "
            "the grey line."
        )
    return (
        "the broad grey line is measured and was never fitted, the dashed line is the model. "
        "The better the model, the closer it stays to the grey line."
    )


def _recording(entry: Mapping[str, Any]) -> str:
    return reading.text(entry, "recording") or "a held-out recording"


def _where(diagnosis: Mapping[str, Any], width: float) -> Picture | None:
    shares = where.shown(diagnosis)
    caption = ""
    if shares:
        name = words.location(reading.text(shares[0], "location"))
        caption = (
            f"Share of the gap by place in the rig. The longest bar says where to look first: "
            f"{name}, with {percent(shares[0].get('share'))}."
        )
    name = "where" if width == style.WIDE else "where-first"
    return picture(lambda w: where.draw(diagnosis, w), name, caption, width)


def _gap(diagnosis: Mapping[str, Any], width: float) -> Picture | None:
    caption = (
        "Error of the model on held-out data. A complete model would reach down to the noise and "
        "no further."
    )
    name = "gap" if width == style.WIDE else "gap-first"
    return picture(lambda w: gap.draw(diagnosis, w), name, caption, width)
