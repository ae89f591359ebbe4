"""Markdown of the studies: tables, and on what machine they were made."""

import datetime
import os
import platform
from collections.abc import Iterable
from pathlib import Path

from tp_jax._files import bytes_of, replaced
from tp_jax.errors import InputError


def row(cells: Iterable[object]) -> str:
    """A line of a table."""
    return "| " + " | ".join(str(cell).replace("|", "\\|") for cell in cells) + " |"


def table(heads: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    """A table."""
    heads = list(heads)
    return "\n".join([row(heads), row("---" for _ in heads), *map(row, rows)])


def circumstances(seed: int) -> str:
    """Date, machine, versions and seed, as one sentence."""
    import jax

    from tp_jax._version import __version__

    processor = platform.processor() or platform.machine() or "unknown processor"
    return (
        f"{datetime.date.today().isoformat()}; {processor}, {os.cpu_count()} CPUs, "
        f"{platform.system()}; JAX on {jax.default_backend()}; Python "
        f"{platform.python_version()}, JAX {jax.__version__}, tp-jax {__version__}; seed {seed}."
    )


def put_into(page: Path, study: str, told: str) -> None:
    """Puts what a study tells between its two lines of a page: `<!-- STUDY: begin -->` and `end`.

    Raises:
        InputError: the page lacks one of the lines.
        OSError: it cannot be read or replaced.
    """
    first, last = f"<!-- {study}: begin -->", f"<!-- {study}: end -->"
    before, begin, rest = bytes_of(page).decode("utf-8").partition(first)
    _, end, after = rest.partition(last)
    if not begin or not end:
        raise InputError(f"{page} lacks the line {last if begin else first}; add it.")
    text = f"{before}{first}\n\n{told}\n\n{last}{after}"
    with replaced(page) as part:
        part.write_text(text, encoding="utf-8", newline="\n")
