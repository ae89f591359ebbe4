"""Time from the shell to a simulated CSV: `tp-jax simulate`, without and with a warm cache."""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from ..bench import Bench
from ..rows import Row, duration, held, plain
from ..timing import spread


def measure(b: Bench) -> tuple[dict, list[Row]]:
    """{"cold": seconds, "warm": {median, low, high}}."""
    b.tell("shell")
    with tempfile.TemporaryDirectory() as folder:
        # a cache folder of its own, empty at first
        environment = {**os.environ, "XDG_CACHE_HOME": folder}
        environment.pop("TP_JAX_CACHE", None)
        target = Path(folder, "run.csv")
        cold = _simulated(target, environment, b.scale.duration)
        warm = spread(
            [_simulated(target, environment, b.scale.duration) for _ in range(b.scale.pairs)]
        )
    name = b.ours.name
    rows = [
        plain("shell", "cold cache", name, duration(cold)),
        held("shell", "shell", "warm cache", name, warm.median, duration(warm.median)),
    ]
    return {"cold": cold, "warm": warm._asdict()}, rows


def _simulated(target: Path, environment: dict[str, str], seconds: float) -> float:
    start = time.perf_counter()
    subprocess.run(
        [
            sys.executable,
            "-m",
            "tp_jax",
            "simulate",
            "--preset",
            "bench",
            "--quiet",
            "--duration",
            str(seconds),
            "--out",
            str(target),
        ],
        check=True,
        env=environment,
    )
    took = time.perf_counter() - start
    target.unlink()
    return took
