"""All figures of an analysis as PNG."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tp_jax._files import replaced
from tp_jax.report import style
from tp_jax.report.sensitivity import (
    correlation,
    elementary_effects,
    profiles,
    singular_values,
    sobol_indices,
    sobol_through_time,
    through_time,
)
from tp_jax.results.sensitivity import SensitivityRecord

FIGURES = {
    "local-through-time": through_time.draw,
    "sobol": sobol_indices.draw,
    "sobol-through-time": sobol_through_time.draw,
    "morris": elementary_effects.draw,
    "correlation": correlation.draw,
    "identifiability": singular_values.draw,
    "profiles": profiles.draw,
}


def write_figures(
    analysis: SensitivityRecord | Mapping[str, Any], folder: str | Path
) -> list[Path]:
    """Draws what there is to draw of an analysis; each file appears whole or not at all.

    Args:
        analysis: result of `sensitivity`, or its JSON, schema tp-jax/sensitivity/1.
        folder: made where it is missing.

    Returns:
        The files written.

    Raises:
        OSError: a file cannot be written.
        TypeError: it is no such JSON.
    """
    found = SensitivityRecord.read(analysis)
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for name, draw in FIGURES.items():
        target = folder / f"{name}.png"
        figure = draw(found)
        if figure is None:
            target.unlink(missing_ok=True)  # of an earlier analysis
            continue
        with replaced(target) as part:
            style.save(figure, part)
        written.append(target)
    return written
