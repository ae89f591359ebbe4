"""Figures of a sensitivity analysis, one per file; `files.write` puts all of them in a folder.

Each `draw` takes the result of `tp_jax.sensitivity` and returns a matplotlib
`Figure` that belongs to no window, or None where there is nothing to draw.
"""

from tp_jax.report.sensitivity.files import write_figures as write_figures
