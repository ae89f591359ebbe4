"""Time from the shell to a report: `tp-jax diagnose` of the package's example, all programs to
be compiled and none, and the memory that either takes.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

from .. import checkouts
from ..bench import Bench
from ..rows import Row, duration, held, plain
from ..timing import spread

COLD = 2  # caches that begin empty

# A process of its own, a small one: Linux counts the memory of who starts a process with it.
WATCH = """
import json, resource, subprocess, sys, time
start = time.perf_counter()
code = subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL).returncode
took = time.perf_counter() - start
used = resource.getrusage(resource.RUSAGE_CHILDREN)
print(json.dumps([code, took, used.ru_utime + used.ru_stime, used.ru_maxrss]))
"""


class Took(NamedTuple):
    """Seconds of a process, those of all processors, and gigabytes (1e9 bytes) at the most."""

    seconds: float
    cpu: float
    gigabytes: float


def measure(b: Bench) -> tuple[dict, list[Row]]:
    """{"cold", "warm": {"seconds": {median, low, high}, "gigabytes"}} of all calls of a kind."""
    if b.against is not None:
        return _beside(b, b.against)
    calls: dict[str, list[Took]] = {"cold": [], "warm": []}
    for k in range(COLD):
        with tempfile.TemporaryDirectory() as folder:
            for call in range(1 + -(-b.scale.pairs // COLD)):
                b.tell(f"diagnosis {k + 1}.{call + 1}")
                took = diagnosed(Path(folder))
                calls["warm" if call else "cold"].append(took)
    numbers, rows = {}, []
    for kind, several in calls.items():
        seconds = spread([took.seconds for took in several])
        most = max(took.gigabytes for took in several)
        numbers[kind] = {"seconds": seconds._asdict(), "gigabytes": most}
        case, name = f"{kind} cache", b.ours.name
        rows += [
            held(
                f"diagnosis {kind}",
                "diagnosis",
                case,
                name,
                seconds.median,
                duration(seconds.median),
            ),
            held("diagnosis memory", "diagnosis", case, name, most, f"{most:.3g} GB"),
        ]
    return numbers, rows


def _beside(b: Bench, ref: str) -> tuple[dict, list[Row]]:
    """{campaign: {checkout: {stage: CPU seconds}, "answers": {checkout: answer}}}."""
    numbers, rows = {}, []
    for campaign, found in checkouts.compared(ref, b.scale.pairs, b.tell):
        took = {name: checkouts.medians(several) for name, several in found.items()}
        answers = {name: several[0].answer for name, several in found.items()}
        numbers[campaign] = {**took, "answers": answers}
        then, now = took[ref], took[checkouts.HERE]
        for stage in now:
            words = f"{then.get(stage, 0.0):.1f} → {now[stage]:.1f} CPU s"
            if stage == "in all":
                words += f", {now[stage] / then[stage]:.2f} times"
                # minutes lie between campaigns: where the rest is cut off, these are told
                print(f"{campaign}: {words}", flush=True)
            rows.append(plain("diagnosis", campaign, stage, words))
        same = answers[ref][:2] == answers[checkouts.HERE][:2]
        told = "the same"
        if not same:
            told = " → ".join(_told(answers[name]) for name in (ref, checkouts.HERE))
        rows.append(plain("diagnosis", campaign, "verdict and causes", told))
        shrinks = [answers[name][2] for name in (ref, checkouts.HERE)]
        words = ("–" if x is None else f"{x:.3f}" for x in shrinks)
        rows.append(plain("diagnosis", campaign, "shrink", " → ".join(words)))
    return numbers, rows


def _told(answer: tuple) -> str:
    verdict, causes, _ = answer
    return f"{verdict}: {', '.join(causes)}" if causes else verdict


def diagnosed(folder: Path, campaign: Path | None = None) -> Took:
    """One call, with its caches in this folder; of the package's example if none is given."""
    environment = {**os.environ, "XDG_CACHE_HOME": str(folder)}
    for name in ("TP_JAX_CACHE", "JAX_COMPILATION_CACHE_DIR"):
        environment.pop(name, None)
    watched = [sys.executable, "-c", WATCH, *_command(folder / "out", campaign)]
    done = subprocess.run(watched, env=environment, check=True, capture_output=True, text=True)
    code, seconds, cpu, most = json.loads(done.stdout)
    if code:
        raise RuntimeError(f"tp-jax diagnose ended with {code}:\n{done.stderr}")
    unit = 1.0 if sys.platform == "darwin" else 1024.0  # bytes
    return Took(seconds, cpu, most * unit / 1e9)


def _command(out: Path, campaign: Path | None) -> list[str]:
    command = [sys.executable, "-m", "tp_jax", "--quiet", "diagnose", "--out", str(out)]
    return command if campaign is None else [*command, str(campaign)]
