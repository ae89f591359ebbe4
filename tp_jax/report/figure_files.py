"""The figures of a report as files of their own, for slides and papers."""

import re
from collections.abc import Sequence
from pathlib import Path

from tp_jax._files import replaced
from tp_jax.report import style
from tp_jax.report.pictures import Picture

#: Where they lie, beside the report.
FOLDER = "figures"

_OURS = re.compile(
    r"(first|gap|where|candidates|moved|state-map|run-\d+|residuals-\d+|law-\d+)\.(png|svg)"
)


def write_figures(drawn: Sequence[Picture], folder: Path) -> None:
    """Writes each figure as NAME.png and NAME.svg; those of an earlier report go.

    Args:
        drawn: figures of one report.
        folder: made where it is missing and there is something to write.

    Raises:
        OSError: a file cannot be written.
    """
    if drawn:
        folder.mkdir(exist_ok=True)
    written = set()
    for one in drawn:
        png, svg = (folder / f"{one.name}.{kind}" for kind in ("png", "svg"))
        with replaced(png) as part:
            style.save(one.figure, part)
        with replaced(svg) as part:
            part.write_text(one.file, encoding="utf-8")
        written |= {png.name, svg.name}
    stale = folder.iterdir() if folder.is_dir() else ()
    for path in list(stale):
        if _OURS.fullmatch(path.name) and path.name not in written:
            path.unlink()
