"""The verdict as a few lines of HTML, for the output of a notebook's cell."""

from html import escape

from tp_jax.report import tables, verdict
from tp_jax.results.diagnosis import DiagnosisRecord


def excerpt(diagnosis: DiagnosisRecord) -> str:
    """The heading, the verdict's sentences, and the errors on held-out data."""
    said = verdict.sentences(diagnosis)
    name = f"{diagnosis.campaign}: " if diagnosis.campaign else ""
    lines = (said.where, f"{said.what} {said.tied}".strip(), said.how_far)
    text = "<br>".join(escape(line) for line in lines)
    return f"<p><b>{escape(name + said.heading)}</b></p><p>{text}</p>{_table(diagnosis)}"


def _table(diagnosis: DiagnosisRecord) -> str:
    found = tables.gap(diagnosis)
    if found is None:
        return ""
    rows = ["".join(f"<td>{escape(cell)}</td>" for cell in row) for row in found.rows]
    body = "".join(f"<tr>{row}</tr>" for row in rows)
    head = "".join(f"<th>{escape(name)}</th>" for name in found.head)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
