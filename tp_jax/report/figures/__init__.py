"""Figures of a diagnosis, one per file: `figures.gap.draw(diagnosis)` and its like.

Each function takes a diagnosis, or the dictionary of it, and returns a matplotlib `Figure` that
belongs to no window and no pyplot state, or None where there is nothing to draw. Matplotlib is
loaded when the first figure is drawn.
"""

from tp_jax.report.figures import candidates as candidates
from tp_jax.report.figures import free_run as free_run
from tp_jax.report.figures import gap as gap
from tp_jax.report.figures import law as law
from tp_jax.report.figures import moved as moved
from tp_jax.report.figures import residuals as residuals
from tp_jax.report.figures import state_map as state_map
from tp_jax.report.figures import where as where
