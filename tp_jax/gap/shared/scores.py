"""Scores of every effect by one rig's screen, and the file that keeps them beside the diagnosis.

Efficient scores and information, as `tp_jax.gap.screen` has them: the rig's own parameters and the
states of its windows are projected out, so those of several rigs add up.
"""

import collections
import dataclasses
import functools
import io
import json
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tp_jax._files import bytes_of, replaced

FORM = 2
"""Form of the files; those of another form count as absent."""

Key = tuple[str, tuple[tuple[str, float], ...]]
"""An effect at one set of shape constants: the same on all rigs."""


@dataclasses.dataclass(frozen=True)
class ScoredVariant:
    """An effect at one set of shape constants, seen on one rig.

    Attributes:
        effect, location: its id and place. shapes: constant to value.
        amplitudes: names and units.
        first: its first column.
        dispersion: scatter of the blocks' scores over what the noise gives them.
    """

    effect: str
    location: str
    shapes: tuple[tuple[str, float], ...]
    amplitudes: tuple[tuple[str, str], ...]
    first: int
    dispersion: float

    @property
    def key(self) -> Key:
        """Names it among all rigs."""
        return self.effect, self.shapes

    @property
    def columns(self) -> slice:
        """Its columns in the rig's arrays."""
        return slice(self.first, self.first + len(self.amplitudes))


@dataclasses.dataclass(frozen=True)
class RigScores:
    """One rig.

    Attributes:
        rig: its name.
        variants: effects with one set of amplitudes for the whole rig.
        score: (E,) efficient scores of the amplitudes: their expectation is -information times the
            amplitudes. Units of both as the amplitudes have them.
        information: (E, E).
        noise: (E, E) covariance of the scores where there is noise alone.
        limits: (E, 2) bounds of the amplitudes.
        own: the causes that the rig's own diagnosis names, each where its screen shows it best.
    """

    rig: str
    variants: tuple[ScoredVariant, ...]
    score: np.ndarray
    information: np.ndarray
    noise: np.ndarray
    limits: np.ndarray
    own: tuple[Key, ...] = ()

    @functools.cached_property
    def by_key(self) -> dict[Key, ScoredVariant]:
        """The variants by what names them."""
        return {variant.key: variant for variant in self.variants}


def of_like_units(rigs: Sequence[RigScores]) -> list[RigScores]:
    """Returns the rigs, without effects whose units are not those of most.

    Torques of a rig whose inertia is not known are per unit of it, which no sum takes beside
    torques. Those of the first rig stay where there are as many of one as of the other.
    """
    units = collections.defaultdict(collections.Counter)
    for rig in rigs:
        for each in rig.variants:
            units[each.key][each.amplitudes] += 1
    usual = {key: count.most_common(1)[0][0] for key, count in units.items()}
    return [
        dataclasses.replace(
            rig, variants=tuple(v for v in rig.variants if v.amplitudes == usual[v.key])
        )
        for rig in rigs
    ]


def write(file: Path, scores: RigScores) -> None:
    """Keeps a rig's scores, replacing what is there.

    Raises:
        OSError: the file cannot be written.
    """
    facts = {
        "form": FORM,
        "rig": scores.rig,
        "own": scores.own,
        "variants": [dataclasses.asdict(each) for each in scores.variants],
    }
    upper = np.triu_indices(len(scores.score))
    arrays: dict[str, Any] = {
        "score": scores.score,
        "limits": scores.limits,
        "information": scores.information[upper],
    }
    if not np.array_equal(scores.noise, scores.information):
        arrays["noise"] = scores.noise[upper]
    with replaced(file) as part, part.open("wb") as stream:
        np.savez_compressed(stream, facts=np.array(json.dumps(facts)), **arrays)


def read(file: Path) -> RigScores | None:
    """The scores that a file keeps; None where there is none, of this form and whole."""
    try:
        with np.load(io.BytesIO(bytes_of(file)), allow_pickle=False) as found:
            arrays = {name: found[name] for name in found.files}
        facts = json.loads(str(arrays["facts"]))
        if facts["form"] != FORM:
            return None
        information = _full(arrays["information"], len(arrays["score"]))
        noise = arrays.get("noise")
        return RigScores(
            rig=facts["rig"],
            variants=tuple(_variant(each) for each in facts["variants"]),
            score=arrays["score"],
            information=information,
            noise=information if noise is None else _full(noise, len(information)),
            limits=arrays["limits"],
            own=tuple((effect, _pairs(shapes)) for effect, shapes in facts["own"]),
        )
    except (OSError, ValueError, EOFError, LookupError, TypeError, zipfile.BadZipFile):
        return None


def _variant(facts: dict) -> ScoredVariant:
    amplitudes = tuple((name, unit) for name, unit in facts["amplitudes"])
    return ScoredVariant(**{**facts, "shapes": _pairs(facts["shapes"]), "amplitudes": amplitudes})


def _pairs(shapes: list) -> tuple[tuple[str, float], ...]:
    return tuple((name, value) for name, value in shapes)


def _full(upper: np.ndarray, n: int) -> np.ndarray:
    """(n, n) symmetric, of its upper half."""
    full = np.zeros((n, n))
    full[np.triu_indices(n)] = upper
    return full + np.triu(full, 1).T
