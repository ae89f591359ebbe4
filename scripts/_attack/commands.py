"""Every command's arguments, spoiled; the work itself is left out, all before and after it is not.

A command whose arguments are taken comes to the function that would work for minutes: that is what
`done` counts here, and what is refused has to be one sentence with exit code 2.
"""

import contextlib
import io
import itertools
import os
import tempfile
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from unittest import mock

from hypothesis import HealthCheck, Phase, Verbosity, given, settings
from hypothesis import seed as with_seed
from hypothesis import strategies as st

from scripts._attack import corpus
from scripts._attack.tally import Tally, Wrong
from tp_jax.errors import InputError

VALID: tuple[tuple[str, ...], ...] = (
    ("simulate", "--preset", "bench", "--duration", "2", "--rate", "50", "--out", "s.csv"),
    (
        "identify",
        "rig",
        "--method",
        "least-squares",
        "--starts",
        "4",
        "--fix",
        "T0=4",
        "--bound",
        "k=0.1:1",
        "--seed",
        "3",
        "--json",
        "i.json",
        "--out",
        "found",
    ),
    ("identify", "rig", "--objective", "free-run", "--raw-starts", "--iterations", "5", "--resume"),
    ("identify", "rig/run-13.csv", "--omega", "13", "--loss", "huber", "--noise", "fit"),
    ("sensitivity", "rig", "--spread", "1.2", "--samples", "64", "--profile", "k", "--json", "-"),
    ("diagnose", "rig", "--tolerance", "0.01", "--seed", "1", "--out", "d", "--json", "d.json"),
    ("diagnose", "rig/decay.csv", "--decay", "--quiet"),
    ("diagnose", "rig", "rig/decay.csv", "--decay", "--out", "d", "--workers", "1", "--resume"),
    ("predict", "diagnosis.json", "--omega", "13", "--duration", "1", "--rate", "50"),
    (
        "predict",
        "diagnosis.json",
        "--phi1",
        "0.5",
        "--duration",
        "1",
        "--rate",
        "50",
        "--model",
        "before",
        "--out",
        "p.csv",
    ),
    ("predict", "diagnosis.json", "--recording", "rig/run-13.csv", "--duration", "1"),
    (
        "record",
        "--port",
        "emulator",
        "--duration",
        "2",
        "--out",
        "r.csv",
        "--omega",
        "13",
        "--amplitude",
        "0.2",
        "--baud",
        "115200",
        "--calibration",
        "rig.toml",
        "--patience",
        "2",
    ),
    (
        "record",
        "--port",
        "emulator",
        "--duration",
        "2",
        "--campaign",
        "rig",
        "--release",
        "0.5",
        "--effect",
        "column_tilt=0.1",
        "--rate",
        "500",
        "--speed",
        "max",
        "--noise",
        "0.001",
        "--skew",
        "20",
        "--corrupt",
        "0.01",
        "--drop",
        "0.01",
        "--unplug",
        "1:0.5",
    ),
    ("rig", "serve", "--effect", "contact_stribeck=0.5,1.0", "--seed", "2", "--run-duration", "9"),
    ("rig", "serve", "--text", "--omega", "13"),
    ("calibrate", "volts.csv", "--out", "new.toml", "--law", "sine_cosine", "--json", "c.json"),
    ("calibrate", "volts.csv", "--out", "rig.toml", "--overwrite", "--degrees"),
    ("blind", "make", "trial", "--cases", "4", "--rigs", "rough", "--workers", "1", "--seed", "5"),
    ("blind", "score", "trial", "--quick", "--first", "2", "--json", "s.json"),
)

WORDS = (
    "",
    " ",
    "-",
    "--",
    "-1",
    "0",
    "nan",
    "inf",
    "1e308",
    "-1e308",
    "1e-320",
    "1e400",
    "1e15",
    "9" * 30,
    "9" * 5000,
    "x",
    "x" * 300,
    "k=1",
    "k=-1",
    "k=1e308",
    "k=nan",
    "magic=1",
    "k=",
    "=",
    "k=1:2",
    "k=2:1",
    "k=0:1e-300",
    "k=1e300:1e308",
    "T0=0:1e308",
    "1:2",
    "nope",
    "all",
    "/",
    ".",
    "..",
    "/dev/null",
    "/dev/full",
    "/dev/null/x",
    "/proc/x",
    "rig",
    "rig/campaign.toml",
    "fifo",
    "spoiled",
    "link",
    "diagnosis.json",
    "rig.toml",
    "missing",
    "--json",
    "--quiet",
    "--help",
    "--seed",
    "--resume",
    "\udcff",
    "φ",
    "a\nb",
    "column_tilt",
    "column_tilt=1e308",
    "emulator",
    "column_tilt=",
    "bearing_drag=1,2,3,4",
    "\x1b[2J",
)

#: What would work for minutes, or on a port: module and name.
WORK = (
    ("tp_jax", "identify"),
    ("tp_jax", "sensitivity"),
    ("tp_jax", "diagnose"),
    ("tp_jax", "simulate"),
    ("tp_jax", "predict"),
    ("trials", "make"),
    ("tp_jax.rig.serve", "serve_until_interrupted"),
    ("tp_jax.acquisition.recorder", "record"),
    ("tp_jax.cli.fleet", "run_pieces"),
)


class Worked(BaseException):
    """The work would begin now."""


@st.composite
def lines(draw: st.DrawFn) -> list[str]:
    """A command line with one to three words changed."""
    words = list(draw(st.sampled_from(VALID)))
    for _ in range(draw(st.sampled_from((1, 1, 2, 3)))):
        at = draw(st.integers(min(1, len(words)), len(words)))
        how = draw(st.sampled_from(("over", "over", "over", "put", "gone", "swap")))
        if how == "put":
            words.insert(at, draw(st.sampled_from(WORDS)))
        elif at < len(words):
            if how == "over":
                words[at] = draw(st.sampled_from(WORDS))
            elif how == "gone":
                del words[at]
            else:
                words[0], words[at] = words[at], words[0]
    return words


def attack(tally: Tally, inputs: int, seed: int = 0) -> None:
    """Tries so many command lines, each in a folder of valid files."""
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        root, count = Path(folder), itertools.count()

        @settings(
            max_examples=max(inputs, 1),
            deadline=None,
            database=None,
            phases=[Phase.generate],
            suppress_health_check=list(HealthCheck),
            verbosity=Verbosity.quiet,
        )
        @given(lines())
        def one(words: list[str]) -> None:
            here = root / str(next(count))
            corpus.Folder(here).made()
            os.mkfifo(here / "fifo")
            (here / "link").symlink_to("link")
            os.chdir(here)
            door = f"command: {words[0] if words and words[0] in COMMANDS else 'other'}"
            tally.attempt(door, lambda: _carried_out(words), words)

        try:
            with _without_work(), mock.patch.dict(os.environ, {"TP_JAX_CACHE": "off"}):
                with_seed(seed)(one)()
        finally:
            os.chdir(before)


COMMANDS = {words[0] for words in VALID}
TRIALS = {("blind", "make"), ("blind", "score")}
"""Begin lines for scripts/blind; all others are for `tp-jax`."""


def _carried_out(words: list[str]) -> None:
    """Runs it; InputError where it was refused as it should be."""
    if tuple(words[:2]) in TRIALS:
        from scripts._blind.__main__ import main

        words = words[1:]
    else:
        from tp_jax.cli import main

    # as a terminal has them: what is no text is an error there
    out = io.TextIOWrapper(io.BytesIO(), encoding="utf-8", errors="strict")
    err = io.TextIOWrapper(io.BytesIO(), encoding="utf-8", errors="backslashreplace")
    try:
        # a notice is a line on standard error, whatever the process makes of warnings
        with (
            contextlib.redirect_stdout(out),
            contextlib.redirect_stderr(err),
            warnings.catch_warnings(),
        ):
            warnings.simplefilter("default")
            code = main(words)
    except Worked:
        return
    err.seek(0)
    said = err.read()
    if code == 0:
        return
    if code != 2:
        raise Wrong(f"exit code {code}: {said[-200:]}")
    if said.count("\n") != 1 or not said.startswith("tp-jax: ") or "Traceback" in said:
        raise Wrong(f"not one sentence: {said[:200]!r}")
    raise InputError(said.strip())


@contextlib.contextmanager
def _without_work() -> Iterator[None]:
    from importlib import import_module

    def begun(*_: Any, **__: Any) -> None:
        raise Worked

    with contextlib.ExitStack() as stack:
        for module, name in WORK:
            stack.enter_context(mock.patch.object(import_module(module), name, begun))
        port = contextlib.nullcontext("emulator")
        stack.enter_context(mock.patch("tp_jax.cli.record._port", return_value=port))
        stack.enter_context(mock.patch("tp_jax.rig.serve.Emulator", mock.MagicMock()))
        yield
