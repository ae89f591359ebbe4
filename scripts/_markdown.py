"""Markdown of the studies: tables, and on what machine they were made."""

import datetime
import os
import platform
from collections.abc import Iterable


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
