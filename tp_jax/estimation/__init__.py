"""Estimation: recordings in windows, fitted by least squares with the window states eliminated.

layout, program, windows, problem    what is estimated, and its one compiled linearisation
elimination, least_squares           Gauss-Newton over unknowns and window states
start, baseline                      a start from the data, windows that grow
blocks, intervals                    scatter of blocks, intervals
free_objective, nelder_mead          the paper's objective and its method
assemble                             a pendulum from the numbers of a fit
identify                             all of it for a user
"""

from tp_jax.estimation.identify import Identification as Identification
from tp_jax.estimation.identify import identify as identify
