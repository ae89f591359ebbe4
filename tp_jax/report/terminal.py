"""The verdict on a terminal: the lines of `text.summary`, in colour where the terminal has any."""

import re
from io import StringIO
from typing import IO, TYPE_CHECKING

from tp_jax.report.text import summary
from tp_jax.results.diagnosis import DiagnosisRecord, Found

if TYPE_CHECKING:
    from rich.text import Text

_HEADINGS = {"explained": "bold green", "no_gap": "bold green", "unknown": "bold yellow"}
_TABLE_HEADS = ("held-out error (rms)", "cause ", "candidate ", "candidate, ")
_STRONG = re.compile(r"[\d.,]+ % of the removable gap is gone")


def show(found: Found, file: IO[str] | StringIO | None = None) -> None:
    """Prints the verdict.

    Colours appear on a terminal only, and not where NO_COLOR is set; elsewhere the text is that
    of `summary`, byte for byte.

    Args:
        found: a diagnosis, or the dictionary of it.
        file: where to; standard output if None.
    """
    from rich.console import Console

    console = Console(file=file, highlight=False, soft_wrap=True)
    if console.is_terminal:
        console.print(coloured(found))
    else:
        print(summary(found), file=console.file)


def coloured(found: Found) -> "Text":
    """The lines of `summary` with styles: heading, heads of tables, causes, what is gone."""
    from rich.text import Text

    diagnosis = DiagnosisRecord.read(found)
    text = Text()
    for i, line in enumerate(summary(diagnosis).splitlines()):
        one = Text(line)
        if i == 0:
            one.stylize(_HEADINGS[diagnosis.verdict or "unknown"])
        elif line.startswith(_TABLE_HEADS):
            one.stylize("dim")
        elif line.startswith(("These recordings cannot tell apart:", "Next:", "What to do:")):
            one.stylize("bold", 0, line.index(":"))
        one.highlight_words(diagnosis.causes, "cyan")
        one.highlight_regex(_STRONG, "bold")
        if i:
            text.append("\n")
        text.append(one)
    return text
