"""Nelder-Mead on (17), from many starts: side by side here, one after another by SciPy.

Same objective, same starts and first simplices, same number of iterations; SciPy's runs go one
after another in one process, with CVODES at the tolerance at which the preset's run has the error
asked for (1e-8 if it is not among the peers), ours at a sweep's own.
"""

import time
from typing import Any

import numpy as np

from ..bench import Bench
from ..problem import SEARCHED
from ..rows import Row, duration, held, plain, times


def measure(b: Bench) -> tuple[dict, list[Row]]:
    """{"starts", "iterations", "results": [{peer, seconds, evaluations, objectives}]}."""
    b.tell("simplices")
    from tp_jax.estimation.prepared_campaign import prepare_campaign

    from .. import campaign as rig

    starts, iterations = b.scale.simplices, b.scale.iterations
    setting = prepare_campaign(rig.made(2, b.scale.recording), fix=rig.KNOWN, effects=())
    x0, limits = _starts(setting, starts)
    results = [_ours(setting, x0, iterations)]
    rows = [_row(results[0], starts, iterations)]
    tol = rig.cvodes_tolerance(b)
    if tol is not None:
        results.append(_scipy(rig.as_plain(setting, tol), x0, limits, iterations))
        rows.append(_row(results[1], starts, iterations))
        factor = results[0]["seconds"] / results[1]["seconds"]
        who = f"{results[1]['peer']}, one process"
        rows.append(
            held(
                "simplices over scipy",
                "simplices",
                f"{starts} starts",
                results[0]["peer"],
                factor,
                f"{times(factor)} {who}",
            )
        )
    return {"starts": starts, "iterations": iterations, "results": results}, rows


def _starts(setting: Any, number: int) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray]]:
    """Starts (number, u) within a third of the rig's numbers, and the bounds of its unknowns."""
    from tp_jax.estimation.fitted import parameter

    from .. import campaign as rig

    problem = setting.problem(setting.horizons[-1])
    specs = {u.name: parameter(problem, u) for u in setting.unknowns()}
    limits = np.array([(specs[n].lower, specs[n].upper) for n in SEARCHED]).T
    factor = 3.0 ** np.random.default_rng(0).uniform(-1.0, 1.0, (number, len(SEARCHED)))
    return np.array([rig.truth()[n] for n in SEARCHED]) * factor, (limits[0], limits[1])


def _ours(setting: Any, x0: np.ndarray, iterations: int) -> dict[str, Any]:
    from tp_jax.estimation.free_run_search import free_run_search
    from tp_jax.estimation.starts import starts as data_start

    base = data_start(setting, 1)[0].values
    starts = [base.replace(dict(zip(SEARCHED, x.tolist(), strict=True))) for x in x0]
    call = lambda: free_run_search(  # noqa: E731
        setting, starts, lambda *_: None, max_iterations=iterations
    )
    call()
    begin = time.perf_counter()
    found = call()
    return {
        "peer": "tp-jax",
        "seconds": time.perf_counter() - begin,
        "objectives": [each[1] for each in found],
        "evaluations": [each[2] for each in found],
    }


def _scipy(runs: Any, x0: np.ndarray, limits: Any, iterations: int) -> dict[str, Any]:
    from ..scipy_script import objective, simplex_search

    objective(x0[0], runs)  # builds the integrator
    begin = time.perf_counter()
    found = [simplex_search(x, runs, limits, iterations) for x in x0]
    return {
        "peer": "SciPy and CVODES",
        "seconds": time.perf_counter() - begin,
        "objectives": [each[1] for each in found],
        "evaluations": [each[2] for each in found],
    }


def _row(one: dict[str, Any], starts: int, iterations: int) -> Row:
    value = f"{duration(one['seconds'])} for {iterations} iterations"
    return plain("simplices", f"{starts} starts", one["peer"], value)
