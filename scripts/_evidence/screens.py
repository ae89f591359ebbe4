"""The screen of a rig as a file: all that the study asks of it, so that it asks in seconds.

A file has two kinds of arrays in addition to a JSON text of plain facts: those of the catalogue's
variants (columns one after another) and those of the sources that are free in every window, each in
axes of its own, one after another.
"""

import dataclasses
import io
import json
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tp_jax._files import bytes_of, replaced

FORM = 2
"""Form of the files; those of another form are made anew."""


@dataclasses.dataclass(frozen=True)
class Variant:
    """An effect of the catalogue at one set of shape constants.

    Attributes:
        effect, location: its id and place. shapes: its constants.
        first, count: its columns. drop: predicted fall of the sum of squares.
    """

    effect: str
    location: str
    shapes: dict[str, float]
    first: int
    count: int
    drop: float

    @property
    def rows(self) -> slice:
        """Its columns."""
        return slice(self.first, self.first + self.count)


@dataclasses.dataclass(frozen=True)
class Saved:
    """A rig's screen.

    Attributes:
        facts: of the rig and what today's rules say of it; see `saving.Facts`.
        variants: all of the catalogue that apply.
        score: (E,) of all columns. information: (E, E).
        typical: (E,) sizes of the amplitudes; limits: (E, 2) their bounds.
        blocks: (B, E) parts of the score. by_block: (B, E, E) of the information.
        noise: (E, D) scores that noise alone would give, after the fit.
        sources: names of what is free in every window.
        ends: (S,) where each source's part of the next two ends.
        variance, free: scores of free coefficients and their variance where there is noise alone.
    """

    facts: dict[str, Any]
    variants: tuple[Variant, ...]
    score: np.ndarray
    information: np.ndarray
    typical: np.ndarray
    limits: np.ndarray
    blocks: np.ndarray
    by_block: np.ndarray
    noise: np.ndarray
    sources: tuple[str, ...]
    ends: np.ndarray
    variance: np.ndarray
    free: np.ndarray

    def of_source(self, i: int) -> tuple[np.ndarray, np.ndarray]:
        """Variances and scores of one source."""
        mine = slice(int(self.ends[i - 1]) if i else 0, int(self.ends[i]))
        return self.variance[mine], self.free[mine]


SINGLE = ("by_block", "noise", "variance", "free")
"""Arrays that are kept in single precision: seven digits are more than a count of rigs needs."""


def write(file: Path, saved: Saved) -> None:
    """Saves a screen, whole or not at all."""
    told = {
        "form": FORM,
        "facts": saved.facts,
        "variants": [dataclasses.asdict(v) for v in saved.variants],
        "sources": saved.sources,
    }
    arrays = {
        f.name: getattr(saved, f.name).astype(np.float32 if f.name in SINGLE else np.float64)
        for f in dataclasses.fields(Saved)
        if f.name not in told
    }
    with replaced(file) as part, part.open("wb") as stream:
        np.savez_compressed(stream, told=np.array(json.dumps(told)), **arrays)


def read(file: Path) -> Saved | None:
    """A saved screen; None if it is of another form, or not whole."""
    try:
        with np.load(io.BytesIO(bytes_of(file)), allow_pickle=False) as found:
            arrays: Mapping[str, np.ndarray] = {name: found[name] for name in found.files}
    except (OSError, ValueError, EOFError, zipfile.BadZipFile):
        return None
    told = json.loads(str(arrays["told"]))
    if told.pop("form") != FORM:
        return None
    return Saved(
        facts=told["facts"],
        variants=tuple(Variant(**v) for v in told["variants"]),
        sources=tuple(told["sources"]),
        **{
            name: x.astype(float) if name != "ends" else x.astype(int)
            for name, x in arrays.items()
            if name != "told"
        },
    )
