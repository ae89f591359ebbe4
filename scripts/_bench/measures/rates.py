"""`tp-jax diagnose` of one rig sampled at 100 Hz, 1 kHz and 10 kHz, with what the package's example
has left in the cache: seconds of all processors, and memory.
"""

import tempfile
from pathlib import Path

from tp_jax.rig import make_campaign

from ..bench import Bench
from ..rows import Row, held, plain
from .diagnosis import diagnosed

RATES = (100.0, 1000.0, 10_000.0)  # Hz
RUNS, DURATION = 6, 10.0
HIDDEN = {"contact_stribeck": 0.5}  # as in the package's example


def measure(b: Bench) -> tuple[dict, list[Row]]:
    """{"rates": {Hz: {"cpu_s", "seconds", "gigabytes"}}, "ratio": most over least CPU time}."""
    numbers, rows, name = {}, [], b.ours.name
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        b.tell("rates: the example")
        diagnosed(folder)
        for rate in RATES:
            b.tell(f"rates: {rate:g} Hz")
            campaign = folder / f"at-{rate:g}"
            make_campaign(campaign, effects=HIDDEN, runs=RUNS, duration=DURATION, rate=rate, seed=1)
            took = diagnosed(folder, campaign)
            numbers[f"{rate:g}"] = {
                "cpu_s": took.cpu, "seconds": took.seconds, "gigabytes": took.gigabytes,
            }  # fmt: skip
            case = f"{rate:g} Hz"
            rows.append(plain("rates", case, name, f"{took.cpu:.3g} CPU s"))
            rows.append(
                held("rates memory", "rates", case, name, took.gigabytes,
                     f"{took.gigabytes:.3g} GB")
            )  # fmt: skip
    cpu = [each["cpu_s"] for each in numbers.values()]
    ratio = max(cpu) / min(cpu)
    rows.append(held("rates ratio", "rates", "most over least", name, ratio, f"{ratio:.3g}"))
    return {"rates": numbers, "ratio": ratio}, rows
