"""The HTML: what the templates show, in words."""

import functools
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tp_jax._version import __version__
from tp_jax.checks.proposal import Driven
from tp_jax.recordings import clocks
from tp_jax.recordings.sources import ColumnSource
from tp_jax.report import words
from tp_jax.report.recordings import drawn_duration
from tp_jax.serve.folder import File, ServedFolder
from tp_jax.serve.pictures import picture

if TYPE_CHECKING:
    from jinja2 import Environment

    from tp_jax.serve.diagnoses import Row
    from tp_jax.serve.jobs import Status
    from tp_jax.serve.limits import Limits

HERE = Path(__file__).parent
REPORT_STYLE = HERE.parent / "report" / "report.css"

LEVELS = {"wrong": "To be mended", "doubtful": "To be looked at", "mended": "Mended in reading"}
"""Level of a finding -> what the page calls it."""

COLUMNS = {"t": "time", "phi1": "φ1", "phi2": "φ2", "drive": "drive"}
"""Name of a column in a recording -> what the page calls it."""

UNITS = {"t": "s", "phi1": "rad", "phi2": "rad"}
"""Name of a column -> its unit where the file is taken to have the recording's own."""


@dataclass(frozen=True)
class Card:
    """A data file on the page.

    Attributes:
        name: of the file.
        fault: why it cannot be used; empty where it can.
        columns: what each column holds: (name, where and in which unit).
        rate, length, samples: in words.
        picture: of both angles, as an `<svg>`; empty without one.
        shown: what the picture shows.
        used: whether the campaign has it.
        kind, omega: how it was driven, as its fields hold it.
        has_drive: whether the file holds a measured drive.
    """

    name: str
    fault: str = ""
    columns: tuple[tuple[str, str], ...] = ()
    rate: str = ""
    length: str = ""
    samples: str = ""
    picture: str = ""
    shown: str = ""
    used: bool = True
    kind: str = "commanded"
    omega: str = ""
    has_drive: bool = False


def page(folder: ServedFolder, diagnoses: "list[Row]", job: "Status", limits: "Limits") -> str:
    """The page."""
    checked = folder.check()
    findings = () if checked is None else checked.findings
    campaign = None if checked is None else checked.campaign
    cards, B1 = _cards(folder)
    template = _environment().get_template("page.html.j2")
    return template.render(
        folder=folder.path.resolve().name,
        version=__version__,
        cards=cards,
        B1=B1,
        by_hand=folder.by_hand,
        has_campaign=checked is not None,
        findings=[
            (LEVELS[each.level], each.level, folder.told(each.sentence)) for each in findings
        ],
        good=checked is not None and not checked.wrong,
        recordings=0 if campaign is None else len(campaign.recordings),
        diagnoses=diagnoses,
        comparable=[row for row in diagnoses if not row.fault],
        job=job_state(job, folder.told),
        limits=limits,
    )


def compared(a: str, b: str, rows: list[tuple[str, str, str]]) -> str:
    """Two diagnoses side by side."""
    template = _environment().get_template("compare.html.j2")
    return template.render(a=a, b=b, rows=rows, version=__version__)


def style() -> str:
    """The style sheet: the report's, and what the page has in addition to it."""
    own = (HERE / "static" / "serve.css").read_text(encoding="utf-8")
    return f"{REPORT_STYLE.read_text(encoding='utf-8')}\n{own}"


def script() -> str:
    """The page's one script."""
    return (HERE / "static" / "serve.js").read_text(encoding="utf-8")


def _cards(folder: ServedFolder) -> tuple[list[Card], str]:
    """The data files, and B1 as its field holds it."""
    said = folder.answers()
    cards = [
        _card(
            file,
            None if said is None else said.driven.get(file.path.name),
            said is None or file.path.name not in said.unused,
        )
        for file in folder.files()
    ]
    return cards, "" if said is None or said.B1 is None else repr(said.B1)


def _card(file: File, driven: Driven | None, used: bool) -> Card:
    seen = file.survey
    if seen is None:
        return Card(file.path.name, words.capital(file.fault.removeprefix(f"{file.path.name}: ")))
    typed = driven is not None  # such a frequency stays as it is, digit by digit
    driven = driven or file.guess or Driven("decay")
    step = clocks.usual_step(seen.t)
    rising = seen.t[np.isfinite(seen.t)]
    length = float(np.ptp(rising)) if rising.size else 0.0
    last = drawn_duration(length, driven.omega)
    angles = {"phi1": seen.phi1} | ({} if seen.phi2 is None else {"phi2": seen.phi2})
    both = "φ1" if seen.phi2 is None else "φ1 above φ2"
    shown = f"{both}, " + (f"the last {last:.3g} s" if last < length else "all of it")
    omega = "" if driven.omega is None else f"{driven.omega!r}" if typed else f"{driven.omega:.6g}"
    return Card(
        file.path.name,
        columns=tuple(
            (COLUMNS[name], _place(name, source, seen.why.get(name, "")))
            for name, source in seen.sources.items()
        ),
        rate=f"{1.0 / step:.4g} Hz" if step else "not known",
        length=f"{length:.4g} s",
        samples=f"{seen.t.size:,}",
        picture=picture(seen.t, angles, last, f"{file.path.name}: {shown}"),
        shown=shown,
        used=used,
        kind=driven.kind,
        omega=omega,
        has_drive="drive" in seen.sources,
    )


def _place(name: str, source: ColumnSource, why: str) -> str:
    """Says where a column stands in the file, in which unit, and what speaks for that."""
    column = source.column
    place = f"column {column + 1}" if isinstance(column, int) else f"“{column}”"
    unit = source.unit or UNITS.get(name, "")
    unit = f" in {unit}" if unit else ""
    if source.counts is not None:
        unit = f" in counts, {source.counts:g} a turn"
    return f"{place}{unit}" + (f" ({why})" if why else "")


@functools.cache
def _environment() -> "Environment":
    from jinja2 import Environment, FileSystemLoader, StrictUndefined
    from markupsafe import Markup

    environment = Environment(
        loader=FileSystemLoader(HERE / "templates", encoding="utf-8"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["drawn"] = Markup  # our own markup, whose texts are escaped
    return environment


def job_state(status: "Status", told: Any) -> dict[str, Any]:
    """A job for the page's script.

    Args:
        status: of the job.
        told: makes a sentence of the folder's one for the page.
    """
    return {**vars(status), "messages": [told(each) for each in status.messages]}
