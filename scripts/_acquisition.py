"""Measures the acquisition against the virtual rig, prints a Markdown table; see `acquisition`."""

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from tp_jax.acquisition import Port, Settings, protocol, record
from tp_jax.acquisition.parser import FrameParser, TextParser
from tp_jax.recordings import load_campaign, read_columns
from tp_jax.rig import VirtualRig
from tp_jax.rig.emulator import Firmware
from tp_jax.rig.serve import Emulator, Line

OMEGA = 13.09

RECORDER = """
import json, resource, sys, time
from tp_jax.acquisition import Settings, record
before, begin = resource.getrusage(resource.RUSAGE_SELF), time.perf_counter()
done = record(sys.argv[1], sys.argv[2], Settings(float(sys.argv[3]), omega=13.09))
used, took = resource.getrusage(resource.RUSAGE_SELF), time.perf_counter() - begin
spent = used.ru_utime + used.ru_stime - before.ru_utime - before.ru_stime
print(json.dumps({"share": spent / took, "state": done.state, **done.metadata}))
"""


class Ledger(Firmware):
    """Remembers the counts of every sample of the run."""

    def __init__(self, *arguments, **options):
        super().__init__(*arguments, **options)
        self.counts = {}
        read = self._bridges.read

        def noted(phi1, phi2):
            self.counts[self.sent - 1] = counts = read(phi1, phi2)
            return counts

        self._bridges.read = noted


@contextmanager
def serving(*options):
    """`tp-jax rig serve` in a process of its own; its port."""
    words = [sys.executable, "-m", "tp_jax", "rig", "serve", "--until-stdin-closes", *options]
    rig = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    try:
        yield rig.stdout.readline().strip()
    finally:
        rig.stdin.close()
        rig.wait()
        rig.stdout.close()


def recorded(port, out, duration):
    """Metadata of a recording made in a process of its own, and that process's share of a core."""
    words = [sys.executable, "-c", RECORDER, port, str(out), str(duration)]
    return json.loads(subprocess.run(words, check=True, capture_output=True, text=True).stdout)


def real_time(folder, seconds):
    for skew in (0, 200, -200):
        with serving(f"--skew={skew}") as port:
            done = recorded(port, folder / f"skew{skew}.csv", seconds)
        samples, clock = done["samples"], done["clock"]
        yield (
            f"{seconds:g} s at 1 kHz, clock {skew:+d} ppm",
            f"{samples['written']} samples, {samples['lost']} lost, "
            f"{done['frames']['corrupt']} corrupt; clock {1e6 * clock['skew']:+.2f} ± "
            f"{1e6 * clock['skew_error']:.2f} ppm; {100 * done['share']:.1f} % of a core",
        )


def bad_line(folder, seconds):
    for corrupt, drop in ((0.01, 0.0), (0.0, 0.01)):
        firmware = Ledger(VirtualRig(), run_duration=seconds)
        with Emulator(firmware, speed=3.0, line=Line(corrupt, drop, 1)) as rig:
            port = Port(rig.port, protocol.BAUD, lambda: 3.0 * time.monotonic())
            settings = Settings(seconds, omega=OMEGA, patience=20.0)
            done = record(port, folder / f"bad{corrupt}.csv", settings)
        values = read_columns(done.path).values
        sequence = np.rint(values["t"] * 1000).astype(int)
        counts = np.array([firmware.counts[n] for n in sequence]) * 3.3 / 65535
        sine, cosine = (counts[:, 0] - 1.652) / 2.61, (counts[:, 1] - 1.638) / 2.58
        wrong = np.abs(0.5 * np.arctan2(sine, cosine) - 0.012 - values["phi1"]) > 1e-9
        samples = done.metadata["samples"]
        total = round(seconds * 1000) + 1
        yield (
            f"{100 * max(corrupt, drop):g} % of bytes {'corrupted' if corrupt else 'dropped'}",
            f"{samples['written']} written + {samples['lost']} counted as lost = "
            f"{samples['written'] + samples['lost']} of {total}; "
            f"{done.metadata['frames']['corrupt']} bad frames; {wrong.sum()} wrong samples",
        )


def unplugged(folder):
    with serving("--unplug=5:3") as port:
        done = recorded(port, folder / "unplugged.csv", 12)
    (gap,) = done["gaps"]
    yield (
        "unplugged at 5 s for 3 s",
        f"{done['state']}; gap marked from {gap['after']:g} to {gap['before']:g} s, "
        f"{gap['samples']} samples; {done['samples']['written']} written",
    )


def killed(folder):
    firmware, out = Firmware(VirtualRig()), folder / "killed.csv"
    lost = []
    for i in range(5):
        out = folder / f"killed{i}.csv"
        with Emulator(firmware) as rig:
            child = subprocess.Popen([sys.executable, "-c", RECORDER, rig.port, str(out), "60"])
            while not out.exists():
                time.sleep(0.01)
            time.sleep(1.0 + 0.13 * i)
            sent = firmware.sent
            os.kill(child.pid, signal.SIGKILL)
            child.wait()
        lost.append(sent - load_campaign(out, omega=OMEGA).recordings[0].n)
        firmware.running = False
    yield "kill -9, five times", f"readable; the last {max(lost)} ms at most are missing"


def fuzzed():
    rng = np.random.default_rng(0)
    frames = b"".join(protocol.sample(1, i, i * 1000, (1, 2, 3, 4)) for i in range(60_000))
    stream = Line(0.02, 0.01, 3).carry(frames) + rng.bytes(2_000_000)
    parser, text, begin = FrameParser(), TextParser(), time.perf_counter()
    for i in range(0, len(stream), 500):
        parser.feed(stream[i : i + 500])
        text.feed(stream[i : i + 500])
    yield (
        f"{len(stream) / 1e6:.1f} million random and mutated bytes",
        f"no fault, {time.perf_counter() - begin:.1f} s; {parser.good} good, "
        f"{parser.corrupt} bad frames",
    )


def importing():
    program = "import time; b = time.perf_counter(); import {}; print(time.perf_counter() - b)"
    for name in ("numpy", "tp_jax.acquisition.recorder"):
        times = [
            float(subprocess.check_output([sys.executable, "-c", program.format(name)]))
            for _ in range(7)
        ]
        yield f"import {name}", f"{min(times):.3f} s"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0, help="of the long recordings (60)")
    seconds = parser.parse_args().seconds
    print("| what | measured |\n|---|---|", flush=True)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for part in (
            importing(),
            real_time(folder, seconds),
            bad_line(folder, seconds),
            unplugged(folder),
            killed(folder),
            fuzzed(),
        ):
            for what, measured in part:
                print(f"| {what} | {measured} |", flush=True)


if __name__ == "__main__":
    main()
