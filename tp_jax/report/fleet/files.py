"""The table of a fleet for other programs: CSV, and Parquet where pyarrow is installed."""

import csv
import importlib
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from tp_jax._files import replaced
from tp_jax.report.fleet.rows import COLUMNS


def csv_text(rows: Sequence[Mapping[str, Any]]) -> str:
    """A header and a line for each rig; numbers with all digits, nothing where there is none."""
    out = io.StringIO()
    writer = csv.DictWriter(out, list(COLUMNS), lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow({name: "" if row[name] is None else row[name] for name in COLUMNS})
    return out.getvalue()


def write_parquet(rows: Sequence[Mapping[str, Any]], path: Path) -> bool:
    """Writes the table, replacing what is there.

    Returns:
        Whether it could be: not without pyarrow.

    Raises:
        OSError: the file cannot be written.
    """
    try:
        pyarrow, parquet = map(importlib.import_module, ("pyarrow", "pyarrow.parquet"))
    except ImportError:
        return False
    kinds = {str: pyarrow.string(), float: pyarrow.float64()}
    schema = pyarrow.schema([(name, kinds[kind]) for name, kind in COLUMNS.items()])
    table = pyarrow.Table.from_pylist([dict(row) for row in rows], schema=schema)
    with replaced(path) as part:
        parquet.write_table(table, part)
    return True
