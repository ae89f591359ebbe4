"""Figures of a sensitivity analysis, one per file; `files.write` puts all of them in a folder.

Each `draw` takes the analysis as in its JSON (tp-jax/sensitivity/1) and returns a matplotlib
`Figure` that belongs to no window, or None where there is nothing to draw.
"""

from tp_jax.report.sensitivity.files import write_figures as write_figures
