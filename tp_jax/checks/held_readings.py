"""Readings that are held: how many a second really come, and how to keep each of them once."""

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from tp_jax.checks.finding import Finding
from tp_jax.recordings import Recording
from tp_jax.recordings.held import held


def findings(recordings: Sequence[Recording]) -> list[Finding]:
    """One finding for all recordings whose readings are held alike.

    It is refused: a reading that is written late is off by what the angle did since, and one that
    is written often counts as often.
    """
    alike: dict[tuple[str, str, str], list[str]] = defaultdict(list)
    rows_of: dict[tuple[str, str, str], float] = {}
    for recording in recordings:
        found = {
            name: each for name, x in recording.channels.items() if (each := held(x)) is not None
        }
        if not found:
            continue
        step = float(np.median(np.diff(recording.t)))
        slowest = max(found.values(), key=lambda each: each.rows)
        names = " and ".join(found)
        key = (names, f"{1.0 / (step * slowest.rows):.4g}", f"{slowest.rows:.4g}")
        alike[key].append(recording.label)
        rows_of[key] = slowest.rows
    return [
        Finding(
            "held",
            "wrong",
            tuple(labels),
            f"readings of {names} come {rate} times a second, and each is written in {rows} rows",
            f"keep one of {rows} rows, as held = true under [format] does",
            {"rate": float(rate), "rows": rows_of[names, rate, rows]},
        )
        for (names, rate, rows), labels in alike.items()
    ]
