"""One sweep of ours in a process of its own, whose peak of memory is then that of this sweep.

It is timed in turns with one of `FEW` lanes, so that what else the machine does hits both alike.
Arguments of the module: lanes, eps, tolerance, duration.
"""

import json
import os
import resource
import subprocess
import sys
from pathlib import Path

os.environ.setdefault("EQX_ON_ERROR", "nan")  # before equinox is imported: see tp_jax._config


FEW = 256
"""Lanes of the sweep that costs are relative to."""

ROUNDS = 3
ROOT = Path(__file__).parent.parent.parent


def sweep_alone(lanes: int, eps: float, tol: float, duration: float) -> dict:
    """{lanes, seconds_per_lane, over_few, bytes_per_lane, bytes_of_angles (per lane)}.

    over_few: median, low, high of the cost per lane over that of `FEW` lanes.
    """
    arguments = (str(value) for value in (lanes, eps, tol, duration))
    done = subprocess.run(
        [sys.executable, "-m", __name__, *arguments],
        check=True,
        text=True,
        stdout=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    return json.loads(done.stdout.splitlines()[-1])


def _here(lanes: int, eps: float, tol: float, duration: float) -> dict:
    """Two lanes first, to see what the program itself takes."""
    import tp_jax._float64  # noqa: F401

    from .peers import ours
    from .problem import sweep, times
    from .timing import interleaved, ratio, spread

    ts = times(duration)
    ours.motions(sweep(2), eps, ts, tol)
    before = _peak()
    table = sweep(lanes)
    done = ours.motions(table, eps, ts, tol)
    peak = _peak()
    of_angles = done.phi1.nbytes + done.phi2.nbytes
    del done
    few = sweep(FEW)
    alike = max(1, round(lanes / FEW))  # readings of both last equally long
    calls = {
        "few": lambda: [ours.motions(few, eps, ts, tol) for _ in range(alike)],
        "all": lambda: ours.motions(table, eps, ts, tol),
    }
    readings = interleaved(calls, ROUNDS)
    per_lane = {
        "few": [took / (alike * FEW) for took in readings["few"]],
        "all": [took / lanes for took in readings["all"]],
    }
    return {
        "lanes": lanes,
        "seconds_per_lane": spread(per_lane["all"]).median,
        "over_few": ratio(per_lane, "all", "few")._asdict(),
        "bytes_per_lane": (peak - before) / lanes,
        "bytes_of_angles": of_angles / lanes,
    }


def _peak() -> int:
    """Largest resident size so far [bytes]."""
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit


if __name__ == "__main__":
    n, *others = sys.argv[1:]
    print(json.dumps(_here(int(n), *(float(value) for value in others))))
