"""The rows on the terminal."""

from collections.abc import Iterable, Mapping

from rich.console import Console
from rich.table import Table
from rich.text import Text

from .rows import Row

WIDTH = 150
"""Columns where the output is no terminal."""


def show(rows: Iterable[Row], machine: Mapping, notes: Iterable[str]) -> None:
    """Prints the table, the machine, and what was left out."""
    console = Console(width=None if Console().is_terminal else WIDTH)
    table = Table()
    for head in ("measure", "case", "who", "value", "bar", "reached"):
        table.add_column(head)
    last = None
    for row in rows:
        if last not in (None, (row.measure, row.case)):
            table.add_section()
        last = row.measure, row.case
        # Text: brackets in it are no markup
        cells = (row.measure, row.case, row.who, row.value, row.bar, verdict(row))
        table.add_row(*(Text(cell) for cell in cells))
    console.print(table)
    versions = ", ".join(f"{name} {version}" for name, version in machine["versions"].items())
    for line in (
        f"{machine['processor']}, {machine['cores']} cores, {machine['device']}; {machine['date']}",
        versions,
        *notes,
    ):
        console.print(Text(line))


def verdict(row: Row) -> str:
    """Says whether the bar was reached, and how far."""
    if row.reached is None or row.margin is None:
        return ""
    word = "yes" if row.reached else "no"
    if row.margin == 0.0:
        return word
    if row.reached:
        return f"{word}, {1.0 / row.margin:.2g} × better"
    return f"{word}, {row.margin:.2g} × above"
