"""A short formula that says the same as a curve, within its band."""

from collections.abc import Iterator

import numpy as np

FLOOR = 0.02
"""Part of the curve's range: a band is taken to be no narrower, since polynomials of degree twelve
follow a kink no better: within a hundredth on average, a twentieth where it is."""

OUTSIDE = 0.05
"""Part of the points of the curve that may lie outside the band, which holds 95 % of them."""

TURNS = range(1, 9)
"""Numbers of waves over an angle."""


def short_formula(
    x: np.ndarray, y: np.ndarray, half: np.ndarray, symbol: str, sided: bool = False
) -> str | None:
    """The simplest of a few formulas that stays within a curve's band.

    Args:
        x, y: (n,) the curve; a constant is free. half: (n,) half width of its band.
        symbol: of x, for the text. sided: whether x is never negative.

    Returns:
        The formula without its constant, or None where no formula fits.
    """
    band = np.maximum(half, FLOOR * max(float(np.ptp(y)), 1e-300))
    for terms, texts in _formulas(x, symbol, sided):
        columns = np.stack([np.ones_like(x), *terms], axis=1)
        found, *_ = np.linalg.lstsq(columns / band[:, None], y / band, rcond=None)
        off = np.abs(y - columns @ found) > band
        if off.mean() <= OUTSIDE:
            return _written(found[1:], texts)
    return None


def _formulas(x: np.ndarray, s: str, sided: bool) -> Iterator[tuple[list, list[str]]]:
    """Terms and their texts, the simplest formulas first."""
    yield [x], [s]
    yield [x**2], [f"{s}²"]
    if not sided:
        yield [np.abs(x)], [f"|{s}|"]
        yield [x**3], [f"{s}³"]
    yield [x, x**2], [s, f"{s}²"]
    if sided:
        for part in (0.02, 0.05, 0.1, 0.2, 0.4, 0.8):
            rate = float(f"{part * x.max():.2g}")
            yield [np.exp(-x / rate)], [f"exp(−{s}/{rate:g})"]
    else:
        yield [x, x**3], [s, f"{s}³"]
        for n in TURNS:
            name = f"{n} {s}" if n > 1 else s
            yield [np.cos(n * x), np.sin(n * x)], [f"cos {name}", f"sin {name}"]


def _written(numbers: np.ndarray, texts: list[str]) -> str:
    """Writes a formula as "0.21 cos 3 φ1 − 0.04 sin 3 φ1"."""
    out = ""
    for value, text in zip(numbers.tolist(), texts, strict=True):
        sign = "−" if value < 0.0 else "+"
        out += f"{f' {sign} ' if out else '−' if value < 0.0 else ''}{abs(value):.3g} {text}"
    return out
