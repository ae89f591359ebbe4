"""Forced runs of a rig as a formula has them, to be written as strange loggers would."""

from pathlib import Path

import numpy as np

NOISE = 1e-3  # rad
OMEGA = 13.09  # rad/s


def made_run(
    n: int = 2500, rate: float = 250.0, omega: float = OMEGA, seed: int = 0
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times [s], the column's angle, and that of a rider that friction drags along [rad]."""
    t = np.arange(n) / rate
    random = np.random.default_rng(seed)
    grows = 1.0 - np.exp(-t / 1.5)
    phi1 = 0.4 * grows * np.sin(omega * t)
    phi2 = 0.28 * grows * np.sin(omega * t - 0.75 * np.pi)
    return t, phi1 + NOISE * random.standard_normal(n), phi2 + NOISE * random.standard_normal(n)


def write_rows(file: Path, header: str, *columns, delimiter: str = ",") -> None:
    """Cells that are texts as they are, numbers with 9 digits."""
    told = [c if isinstance(c[0], str) else [f"{x:.9g}" for x in c] for c in columns]
    rows = [delimiter.join(row) for row in zip(*told, strict=True)]
    file.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")


def write_toml(folder: Path, omegas: dict[str, float], form: str = "") -> None:
    entries = [f'[[recording]]\nfile = "{f}"\nomega = {w}' for f, w in omegas.items()]
    text = "\n".join(['name = "strange"', *([form] if form else []), *entries]) + "\n"
    (folder / "campaign.toml").write_text(text, encoding="utf-8")
