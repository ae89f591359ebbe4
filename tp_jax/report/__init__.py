"""Output for people: a diagnosis as a page, as text and as figures; a trajectory as a picture.

    words, formatting      names in sentences, numbers as text
    verdict                a diagnosis that may lack anything -> three plain sentences
    text -> terminal       the verdict as plain text, `summary`, and in colour, `show`
    excerpt                the verdict as the output of a notebook's cell
    style -> figures       one look for all figures
    captions -> pictures   the figures of the page, and what they show in words
    tables, run_tables     every table of the page
    -> html                everything together in one file, `write_report`
    fleet                  the table and the page of many rigs
    figure_files           the figures beside it as PNG and SVG
    trajectory             the figure of `tp-jax simulate --plot`
    arviz_export           draws of fitted parameters for ArviZ, `to_arviz`

All start from what diagnosis.json holds, as `tp_jax.results.diagnosis.DiagnosisRecord` or as its
dictionary: a report can be made again without JAX.
"""

from tp_jax.report.arviz_export import to_arviz as to_arviz
from tp_jax.report.html import write_report as write_report
from tp_jax.report.terminal import show as show
from tp_jax.report.text import summary as summary
from tp_jax.report.trajectory import plot_trajectory as plot_trajectory
