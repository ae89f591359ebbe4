"""The diagnoses in a served folder: found, numbered, summed up, set side by side."""

import os
import re
import threading
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from tp_jax.errors import InputError
from tp_jax.report import comparison, verdict, words
from tp_jax.report.formatting import MISSING, percent
from tp_jax.results.diagnosis import DiagnosisRecord
from tp_jax.serve.names import readable

RESULT, REPORT = "diagnosis.json", "report.html"


@dataclass(frozen=True)
class Row:
    """A diagnosis in the list.

    Attributes:
        name: of its folder.
        made: when, in the time of this computer.
        verdict, cause, shrink: in words.
        report: whether there is one to open.
        fault: why it cannot be read; empty where it can.
    """

    name: str
    made: str
    verdict: str = ""
    cause: str = ""
    shrink: str = ""
    report: bool = False
    fault: str = ""


class Diagnoses:
    """Diagnoses below a folder; methods may be called from any thread."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._lock = threading.Lock()
        self._known: dict[str, tuple[int, Row]] = {}

    def free(self) -> Path:
        """A folder for the next one: diagnosis-1, diagnosis-2, ..."""
        used = [re.fullmatch(r"diagnosis-(\d+)", each.name) for each in self.folder.iterdir()]
        return self.folder / f"diagnosis-{1 + max((int(m[1]) for m in used if m), default=0)}"

    def rows(self) -> list[Row]:
        """All of them, the latest first."""
        found = []
        for each in self.folder.iterdir():
            file = each / RESULT
            if not each.name.startswith(".") and readable(self.folder, file):
                found.append((file.stat().st_mtime_ns, file))
        with self._lock:
            return [self._row(when, file) for when, file in sorted(found, reverse=True)]

    def file(self, name: str, which: str) -> Path | None:
        """A file of a diagnosis that is in the list; None where there is none."""
        if name not in [row.name for row in self.rows()]:
            return None
        path = self.folder / name / which
        return path if readable(self.folder, path) else None

    def compared(self, a: str, b: str) -> list[comparison.Row]:
        """Two of them as lines of a table: what, in the first, in the second.

        Raises:
            InputError: one is not in the list, or cannot be read.
        """
        files = [file for name in (a, b) if (file := self.file(name, RESULT)) is not None]
        if len(files) < 2:
            raise InputError("Choose two diagnoses of the list.")
        return comparison.rows(*(DiagnosisRecord.from_json(file, fits=False) for file in files))

    def _row(self, when: int, file: Path) -> Row:
        name = file.parent.name
        known = self._known.get(name)
        if known is not None and known[0] == when:
            return known[1]
        made = datetime.fromtimestamp(when / 1e9).strftime("%Y-%m-%d %H:%M")
        report = readable(self.folder, file.parent / REPORT)
        try:
            row = _summed(name, made, report, DiagnosisRecord.from_json(file, fits=False))
        except InputError as fault:
            fault_here = str(fault).replace(f"{self.folder}{os.sep}", "")
            row = Row(name, made, report=report, fault=fault_here)
        if report:  # which comes last; until then the next look may find it
            self._known[name] = (when, row)
        return row


def _summed(name: str, made: str, report: bool, diagnosis: DiagnosisRecord) -> Row:
    return Row(
        name,
        made,
        verdict.sentences(diagnosis).heading,
        words.effect(diagnosis.causes[0]) if diagnosis.causes else MISSING,
        percent(diagnosis.gap.shrink),
        report,
    )
