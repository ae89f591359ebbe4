"""Whether a fitted model is valid: are its residuals noise, its parameters the same everywhere?

series                               residuals over time, with the motion they belong to
null                                 what white noise leaves of itself after a fit
ljung_box, runs, breusch_pagan, analysis_of_variance     one test each
residual_tests                       all of them, adjusted for their number
consistency                          each recording fitted alone; are the parameters equal?
reduction                            the smallest baseline that is not rejected
validate                             all of it; warnings for `identify`
"""

from tp_jax.validation.consistency import Consistency as Consistency
from tp_jax.validation.consistency import consistency as consistency
from tp_jax.validation.reduction import Reduction as Reduction
from tp_jax.validation.reduction import reduction as reduction
from tp_jax.validation.residual_tests import ResidualTests as ResidualTests
from tp_jax.validation.residual_tests import residual_tests as residual_tests
from tp_jax.validation.validate import Validation as Validation
from tp_jax.validation.validate import validate as validate
