"""Figures of a multi-start search: `tp-jax identify --out DIR`."""

from collections.abc import Callable
from typing import Any

from tp_jax.report.starts.unknowns import unknowns
from tp_jax.report.starts.waterfall import waterfall

#: By the name of the file.
FIGURES: dict[str, Callable[..., Any]] = {"waterfall": waterfall, "parameters": unknowns}
