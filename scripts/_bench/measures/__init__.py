"""The measurements, one per file: each a `measure(bench)` that returns numbers and rows."""

from collections.abc import Callable

from . import (
    control,
    diagnosis,
    growth,
    identification,
    precision,
    robustness,
    scaling,
    sensitivities,
    shell,
    simplices,
    single,
    stuck,
    sweep,
)

MEASURES: dict[str, Callable] = {
    module.__name__.rpartition(".")[2]: module.measure
    for module in (
        precision,
        single,
        sweep,
        sensitivities,
        stuck,
        robustness,
        control,
        scaling,
        shell,
        diagnosis,
        growth,
        identification,
        simplices,
    )
}
