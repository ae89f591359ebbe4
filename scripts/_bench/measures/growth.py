"""`tp-jax diagnose` of one rig as recordings become more and samples denser: seconds of all
processors, and memory.

With what the package's example and a first call have left in the cache, so that compiling counts
for nothing; a call that took longer than `TWICE` counts as it is.
"""

import tempfile
from pathlib import Path

from tp_jax.rig import make_campaign

from ..bench import Bench
from ..rows import Row, held, plain
from .diagnosis import Took, diagnosed

RATES = (100.0, 1000.0, 10_000.0)  # Hz, of RUNS recordings
RUNS, DURATION = 6, 10.0  # s
RECORDINGS = (2, 5, 20, 50, 200)  # at RATE
RATE = 1000.0  # Hz
HIDDEN = {"contact_stribeck": 0.5}  # as in the package's example
TWICE = 120.0  # CPU s of a first call above which there is no second
LONGEST = 1500.0  # CPU s that the next call may be expected to take


def measure(b: Bench) -> tuple[dict, list[Row]]:
    """{"rates": {Hz: took}, "recordings": {number: took}, "ratio": most over least CPU time of the
    rates}; took is {"cpu_s", "seconds", "gigabytes"}.
    """
    rows: list[Row] = []
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        b.tell("growth: the example")
        diagnosed(folder)
        rates = {}
        for rate in RATES:
            rates[f"{rate:g}"] = _row(b, rows, f"{rate:g} Hz", _took(b, folder, RUNS, rate))
        recordings, each = {}, 0.0  # CPU s of one
        for n in RECORDINGS:
            if n * each > LONGEST:
                words = f"skipped: about {n * each:.3g} CPU s"
                rows.append(plain("growth", f"{n} recordings", b.ours.name, words))
                continue
            took = _took(b, folder, n, RATE)
            recordings[f"{n}"] = _row(b, rows, f"{n} recordings", took)
            each = took.cpu / n
    cpu = [each["cpu_s"] for each in rates.values()]
    ratio = max(cpu) / min(cpu)
    rows.append(
        held("rates ratio", "growth", "rates, most over least", b.ours.name, ratio, f"{ratio:.3g}")
    )
    return {"rates": rates, "recordings": recordings, "ratio": ratio}, rows


def _took(b: Bench, folder: Path, runs: int, rate: float) -> Took:
    b.tell(f"growth: {runs} recordings at {rate:g} Hz")
    campaign = folder / f"{runs}-at-{rate:g}"
    make_campaign(campaign, effects=HIDDEN, runs=runs, duration=DURATION, rate=rate, seed=1)
    took = diagnosed(folder, campaign)
    return diagnosed(folder, campaign) if took.cpu < TWICE else took


def _row(b: Bench, rows: list[Row], case: str, took: Took) -> dict[str, float]:
    rows.append(plain("growth", case, b.ours.name, f"{took.cpu:.3g} CPU s"))
    rows.append(
        held(
            "growth memory", "growth", case, b.ours.name, took.gigabytes, f"{took.gigabytes:.3g} GB"
        )
    )
    return {"cpu_s": took.cpu, "seconds": took.seconds, "gigabytes": took.gigabytes}
