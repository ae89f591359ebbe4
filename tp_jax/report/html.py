"""One file that holds the whole report: styles and figures inside, nothing fetched, no script."""

import os
import re
from collections.abc import Mapping
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from tp_jax._files import replaced
from tp_jax._version import __version__
from tp_jax.report import pictures, run_tables, tables, verdict, words
from tp_jax.report.figure_files import FOLDER, write_figures
from tp_jax.report.figures.curves import drawable
from tp_jax.results.diagnosis import DiagnosisRecord, Found

if TYPE_CHECKING:
    from jinja2 import Environment

TEMPLATE = "report.html.j2"

FIRST_CANDIDATES = 6
"""Rows of the candidates that are shown at once; the others are folded away."""

LONG = 12
"""Rows from which on a table is folded away: more than a screen of them hides what follows."""


class Part(NamedTuple):
    """A part of the page, as the contents list it; its section is named part-`id`."""

    id: str
    title: str


def write_report(
    found: Found,
    path: str | os.PathLike[str],
    *,
    figures: bool = False,
    day: date | None = None,
) -> None:
    """Writes the report of a diagnosis as one HTML file, which holds its figures.

    A file that is there is replaced at once and whole.

    Args:
        found: a diagnosis, or the dictionary of it; whatever is missing is left out.
        path: the file; its folder must exist.
        figures: whether to write them to `figures/` in the same folder too, as PNG and SVG. What
            lies there stays otherwise.
        day: on which the diagnosis was made, for the head of the page; diagnosis.json, which is the
            same whenever it is made, does not hold it.

    Raises:
        OSError: a file cannot be written.
    """
    diagnosis = DiagnosisRecord.read(found)
    drawn = pictures.pictures(diagnosis)
    text = _page(diagnosis, drawn, day)
    target = Path(os.path.realpath(path))
    with replaced(target) as part:
        part.write_text(text, encoding="utf-8", newline="\n")
    if target.is_file():  # none beside /dev/null; those of an earlier report would contradict it
        write_figures(drawn.every() if figures else [], target.parent / FOLDER)


def render(found: Found, *, day: date | None = None) -> str:
    """The report as text; `day`: see `write_report`."""
    diagnosis = DiagnosisRecord.read(found)
    return _page(diagnosis, pictures.pictures(diagnosis), day)


def environment() -> "Environment":
    """Returns what fills the templates of this folder."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined
    from markupsafe import Markup

    made = Environment(
        loader=FileSystemLoader(Path(__file__).parent, encoding="utf-8"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters["initial"] = words.capital
    made.filters["together"] = _together
    made.filters["drawn"] = Markup  # markup of our own, whose texts are escaped
    return made


def _page(diagnosis: DiagnosisRecord, drawn: pictures.Pictures, day: date | None) -> str:
    return environment().get_template(TEMPLATE).render(context(diagnosis, drawn, day))


def context(
    diagnosis: DiagnosisRecord, drawn: pictures.Pictures, day: date | None = None
) -> dict[str, Any]:
    """Collects what the template shows: sentences, tables of text, figures."""
    shown = {
        "campaign": diagnosis.campaign or "unnamed campaign",
        "model": diagnosis.model,
        "kind": diagnosis.verdict or "unknown",
        "verdict": verdict.sentences(diagnosis),
        "version": diagnosis.provenance.version or __version__,
        "drawn_figures": drawn,
        "gap": tables.gap(diagnosis),
        "floor": tables.floor_line(diagnosis),
        "by_run": run_tables.runs(diagnosis),
        "shrink": tables.shrink_line(diagnosis) if diagnosis.accepted else "",
        "not_drawn": _not_drawn(diagnosis),
        "too_sparse": _too_sparse(diagnosis, drawn),
        "places": tables.places(diagnosis),
        "causes": tables.causes(diagnosis),
        "candidates": tables.first_rows(tables.candidates(diagnosis), FIRST_CANDIDATES),
        "inapplicable": tables.inapplicable(diagnosis),
        "long": LONG,
        "dates": _dates(diagnosis, day),
        "day": "" if day is None else day.isoformat(),
        "scale": tables.scale_line(diagnosis),
        "groups": _groups(diagnosis),
        "groups_known": diagnosis.confused_with is not None,
        "detectable": tables.detectable(diagnosis),
        "parameters": tables.parameters(diagnosis),
        "moved": bool(diagnosis.absorbed),
        "next": verdict.next_experiment(diagnosis),
        "notes": diagnosis.notes,
        "data": run_tables.data(diagnosis),
        "provenance": tables.provenance(diagnosis),
    }
    return {**shown, "contents": _contents(shown)}


def _contents(shown: Mapping[str, Any]) -> list[Part]:
    """The parts of the page that have something to show, in their order."""
    drawn = shown["drawn_figures"]
    parts = (
        (
            "errors",
            "Before and after" if shown["causes"] else "On held-out data",
            shown["gap"] or drawn.runs,
        ),
        ("when", "When", drawn.windows),
        ("where", "Where", shown["places"]),
        ("effects", "Which effect", shown["causes"] or shown["candidates"][0]),
        ("apart", "Not told apart", shown["groups"] or shown["groups_known"]),
        ("detectable", "Detectable sizes", shown["detectable"]),
        ("parameters", "Parameters", shown["parameters"]),
        ("next", "Next experiment", shown["next"]),
        ("notes", "Notes", shown["notes"]),
        ("data", "Data", shown["data"] or shown["provenance"]),
    )
    return [Part(id, title) for id, title, there in parts if there]


def _dates(diagnosis: DiagnosisRecord, day: date | None) -> list[str]:
    """Says when the recordings were made, and the report of them."""
    days = diagnosis.recorded
    recorded = f"recorded {' to '.join(days)}" if days else ""
    written = "" if day is None else f"report of {day.isoformat()}"
    return [said for said in (recorded, written) if said]


def _too_sparse(diagnosis: DiagnosisRecord, drawn: pictures.Pictures) -> bool:
    """True where there are residuals but no map of them over the motion."""
    return bool(drawn.windows) and drawn.state_map is None and bool(drawable(diagnosis.curves))


def _not_drawn(diagnosis: DiagnosisRecord) -> str:
    left_out = diagnosis.curves[pictures.MOST_RECORDINGS :]
    more = [run.recording for run in left_out if run.recording]
    return f"Held out as well, but not drawn: {words.listed(more)}." if more else ""


def _groups(diagnosis: DiagnosisRecord) -> list[list[tables.Named]]:
    return [
        [tables.Named(words.clause(name) or name, name) for name in group]
        for group in diagnosis.groups
    ]


def _together(text: str) -> str:
    """The text with numbers and their units on one line."""
    return re.sub(r"(?<=\d) (?=[%mµ×\d]|rad\b|s\b)", "\u00a0", text)
