"""The gap between model and recordings: where it lies, what causes it, how far it shrinks.

applicability, directions   which effects, at which shape constants
screen, structure, rounding all of them from one linearisation; is anything there at all
refit, short_windows, crossvalidation
                            the best few, nonlinearly, judged inside the fitted data
choice, worth_refitting, earning
                            the causes, one by one; which effects are refitted, which earns its
                            place
learned, visited            laws that nobody wrote down, where the causes leave structure; their
                            range
law_curve, short_formula    what is told of such a law
known_noise                 the causes under the noise that they leave
held_out, free_run          what is left on data no choice has touched
location, detectability, experiment, verdict
tables, assemble            the result, table by table
diagnosis                   all of it together
predict                     a run never seen
shared                      effects that the rigs of a fleet share, from their screens
forecast, next_run          runs that may come next; which of them tells the causes apart
"""

from tp_jax.gap.diagnosis import Diagnosis as Diagnosis
from tp_jax.gap.diagnosis import diagnose as diagnose
from tp_jax.gap.predict import predict as predict
