"""One file that holds the whole report: styles and figures inside, nothing fetched, no script."""

import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tp_jax._version import __version__
from tp_jax.report import pictures, reading, style, tables, verdict, words

TEMPLATE = "report.html.j2"

NO_FIGURES = (
    "This report has no figures, since matplotlib is not installed. To have them, install "
    "tp-jax[plots] and make the report again."
)


def write_report(diagnosis: Mapping[str, Any], path: str | os.PathLike[str]) -> None:
    """Writes the report of a diagnosis as one HTML file.

    A file that is there is replaced at once and whole.

    Args:
        diagnosis: as in diagnosis.json; whatever is missing is left out.
        path: the file; its folder must exist.

    Raises:
        OSError: the file cannot be written.
    """
    text = render(diagnosis)
    target = Path(os.path.realpath(path))  # through links: they are to keep pointing there
    if target.exists() and not target.is_file():
        target.write_text(text, encoding="utf-8")  # a folder says so itself, a device takes it
        return
    # in the same folder, since a file can be renamed at once only within one file system
    part = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        part.write_text(text, encoding="utf-8", newline="\n")
        os.replace(part, target)
    finally:
        part.unlink(missing_ok=True)


def render(diagnosis: Mapping[str, Any]) -> str:
    """The report as text."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined
    from markupsafe import Markup

    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent, encoding="utf-8"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["initial"] = words.capital
    environment.filters["together"] = _together
    environment.filters["drawn"] = Markup  # the figures' own markup, whose texts are escaped
    return environment.get_template(TEMPLATE).render(context(diagnosis))


def context(diagnosis: Mapping[str, Any]) -> dict[str, Any]:
    """What the template shows: sentences, tables of text, figures."""
    figures = style.available()
    kind = reading.verdict(diagnosis)
    return {
        "campaign": reading.text(diagnosis, "campaign") or "unnamed campaign",
        "model": reading.text(diagnosis, "model"),
        "kind": kind,
        "verdict": verdict.sentences(diagnosis),
        "version": reading.text(reading.table(diagnosis, "provenance"), "version") or __version__,
        "first": pictures.first(diagnosis) if figures else None,
        "no_figures": "" if figures else NO_FIGURES,
        "gap": tables.gap(diagnosis),
        "shrink": tables.shrink_line(diagnosis) if reading.causes(diagnosis) else "",
        "runs": pictures.runs(diagnosis) if figures else [],
        "windows": pictures.windows(diagnosis) if figures else [],
        "not_drawn": _not_drawn(diagnosis),
        "places": tables.places(diagnosis),
        "places_picture": _second_where(diagnosis) if figures else None,
        "causes": tables.causes(diagnosis),
        "candidates": tables.candidates(diagnosis),
        "bars": pictures.bars(diagnosis) if figures else None,
        "inapplicable": reading.inapplicable(diagnosis),
        "groups": _groups(diagnosis),
        "groups_known": isinstance(diagnosis.get("confused_with"), list | tuple),
        "detectable": tables.detectable(diagnosis),
        "parameters": tables.parameters(diagnosis),
        "moved": bool(reading.table(diagnosis, "absorbed")),
        "next": verdict.next_experiment(diagnosis),
        "notes": reading.texts(diagnosis, "notes"),
        "provenance": tables.provenance(diagnosis),
    }


def _second_where(diagnosis: Mapping[str, Any]) -> pictures.Picture | None:
    """The places' figure, unless it stands beside the verdict or would be a single bar."""
    if reading.verdict(diagnosis) == "unknown" or len(reading.rows(diagnosis, "where")) < 2:
        return None
    return pictures.places(diagnosis)


def _not_drawn(diagnosis: Mapping[str, Any]) -> str:
    held_out = [reading.text(entry, "recording") for entry in reading.rows(diagnosis, "curves")]
    more = [name for name in held_out[pictures.MOST_RECORDINGS :] if name]
    return f"Held out as well, but not drawn: {words.listed(more)}." if more else ""


def _groups(diagnosis: Mapping[str, Any]) -> list[list[tables.Named]]:
    return [
        [tables.Named(words.EFFECTS.get(name, name), name) for name in group]
        for group in reading.groups(diagnosis)
    ]


def _together(text: str) -> str:
    """The text with numbers and their units on one line."""
    return re.sub(r"(?<=\d) (?=[%mµ×\d]|rad\b|s\b)", "\u00a0", text)
