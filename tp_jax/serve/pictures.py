"""A small picture of both angles, as an SVG element without a style of its own.

The page's policy lets no element bring styles, which figures of matplotlib do; colours are classes.
"""

import html

import numpy as np

WIDTH, STRIP, GAP = 320, 46, 6
"""Units of the picture: its width, the height of an angle's strip, and between the two."""


def picture(t: np.ndarray, angles: dict[str, np.ndarray], last: float, label: str) -> str:
    """The end of a recording.

    Args:
        t: (n,) times [s].
        angles: name -> (n,) angle [rad].
        last: seconds at the end that are drawn.
        label: what it shows, in words.

    Returns:
        An `<svg>`; empty where there is nothing to draw.
    """
    part = np.isfinite(t)
    t = t[part]
    if t.size < 2 or not np.ptp(t):
        return ""
    seen = t >= t[-1] - last
    lines = []
    for i, (name, values) in enumerate(angles.items()):
        points = _points(t[seen], values[part][seen], i * (STRIP + GAP))
        lines.append(f'<polyline class="{name}" points="{points}"/>')
    height = len(angles) * (STRIP + GAP) - GAP
    return (
        f'<svg class="angles" role="img" aria-label="{html.escape(label)}" '
        f'viewBox="0 0 {WIDTH} {height}" preserveAspectRatio="none">{"".join(lines)}</svg>'
    )


def _points(t: np.ndarray, x: np.ndarray, top: float) -> str:
    """Least and largest value in each column of the picture, in the order in which they come."""
    good = np.isfinite(x)
    t, x = t[good], x[good]
    if not t.size:
        return ""
    across = (t - t[0]) / (np.ptp(t) or 1.0) * WIDTH
    low, width = float(x.min()), float(np.ptp(x)) or 1.0
    down = top + 1.0 + (STRIP - 2.0) * (1.0 - (x - low) / width)
    kept = np.arange(t.size)
    if t.size > 2 * WIDTH:
        edges = np.searchsorted(np.maximum.accumulate(across), np.arange(WIDTH))
        ends = [*edges[1:].tolist(), t.size]
        pairs = [
            (a + int(np.argmin(x[a:b])), a + int(np.argmax(x[a:b])))
            for a, b in zip(edges.tolist(), ends, strict=True)
            if b > a
        ]
        kept = np.unique(np.asarray(pairs).ravel())
    return " ".join(f"{across[i]:.1f},{down[i]:.1f}" for i in kept)
