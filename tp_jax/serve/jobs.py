"""One diagnosis at a time, in a process of its own that ends with this one."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tp_jax.errors import InputError
from tp_jax.serve.limits import Limits

Child = Callable[[Path, Path], list[str]]
"""The command line that diagnoses a campaign (first) into a folder (second)."""

SAYS = "tp-jax: "
"""Beginning of a sentence of a command for its user."""


FITS = "fits.json"
"""File that a diagnosis keeps of itself until it is done."""


def diagnosing(campaign: Path, out: Path) -> list[str]:
    """`tp-jax diagnose` by this interpreter, which takes no module from the folder it is in."""
    return [
        sys.executable,
        "-P",
        "-m",
        "tp_jax",
        "diagnose",
        str(campaign),
        "--out",
        str(out),
        "--quiet",
        "--progress",
        "json",
        "--until-stdin-closes",
    ]


@dataclass(frozen=True)
class Status:
    """State of a job.

    Attributes:
        state: "none", "running", "done", "failed" or "cancelled".
        name: of the diagnosis.
        stage: in words.
        part: of the stage that is done, 0 to 1; None: not known.
        seconds: since it began, or that it took.
        messages: what the child said in addition to its progress, a sentence each.
    """

    state: str = "none"
    name: str = ""
    stage: str = ""
    part: float | None = None
    seconds: float = 0.0
    messages: tuple[str, ...] = ()


class Jobs:
    """Starts, watches and ends the child; its methods may be called from any thread."""

    def __init__(self, child: Child, limits: Limits) -> None:
        self._child, self._limits = child, limits
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._thread: threading.Thread | None = None
        self._status = Status()
        self._begun = 0.0
        self._cancelled = self._closed = False

    def start(self, campaign: Path, out: Path) -> None:
        """Starts the diagnosis of a campaign into a folder that it makes.

        Raises:
            InputError: one is running, or `close` was called.
        """
        with self._lock:
            if self._closed:
                raise InputError("The page is being closed; start it anew.")
            if self._status.state == "running":
                raise InputError("A diagnosis is running; wait for its end, or cancel it.")
            out.mkdir()
            try:
                self._process = subprocess.Popen(
                    self._child(campaign, out),
                    stdin=subprocess.PIPE,
                    stdout=subprocess.DEVNULL,
                    stderr=subprocess.PIPE,
                    env=os.environ | {"PYTHONPATH": _with_package(os.environ)},
                    start_new_session=True,  # Ctrl-C in the terminal is for the server
                )
            except OSError:
                out.rmdir()
                raise
            self._cancelled, self._begun = False, time.monotonic()
            self._status = Status("running", out.name, "starting")
            self._thread = threading.Thread(
                target=self._watch, args=(self._process, out), name="tp-jax-job", daemon=True
            )
            self._thread.start()

    def status(self) -> Status:
        """Returns the state of the latest job."""
        with self._lock:
            if self._status.state == "running":
                return self._with(seconds=time.monotonic() - self._begun)
            return self._status

    def cancel(self) -> None:
        """Ends the job that runs, if one does, and waits for its end."""
        with self._lock:
            process, thread = self._process, self._thread
            if process is None or thread is None or self._status.state != "running":
                return
            self._cancelled = True
        _signal(process, signal.SIGINT)
        thread.join(self._limits.grace)
        if thread.is_alive():
            _signal(process, signal.SIGKILL)
            thread.join(self._limits.grace)

    def close(self) -> None:
        """Ends the job that runs; no other can be started."""
        with self._lock:
            self._closed = True
        self.cancel()

    def _watch(self, process: "subprocess.Popen[bytes]", out: Path) -> None:
        assert process.stderr is not None
        assert process.stdin is not None
        messages: deque[str] = deque(maxlen=self._limits.messages)
        other = ""  # of a library, or of the interpreter: reported only where nothing else is
        for raw in process.stderr:
            line = raw.decode("utf-8", "replace").strip()
            told = _progress(line)
            with self._lock:
                if told is not None:
                    self._status = self._with(stage=told[0], part=told[1])
                elif line.startswith(SAYS):
                    messages.append(line.removeprefix(SAYS))
                    self._status = self._with(messages=tuple(messages))
                else:
                    other = line or other
        code = process.wait()
        process.stderr.close()
        with contextlib.suppress(OSError):
            process.stdin.close()
        with self._lock:
            if self._cancelled:  # nobody goes on from it here, whatever the child says of that
                (out / FITS).unlink(missing_ok=True)
                messages.clear()
                self._status = self._with(messages=())
        with contextlib.suppress(OSError):
            out.rmdir()  # only where nothing is in it
        with self._lock:
            state = "cancelled" if self._cancelled else "done" if code == 0 else "failed"
            if state == "failed" and not messages:
                said = f"its last words: {other}" if other else "it said nothing"
                messages.append(f"The diagnosis ended with the code {code}; {said}.")
            self._status = self._with(
                state=state,
                part=None,
                messages=tuple(messages),
                seconds=time.monotonic() - self._begun,
            )

    def _with(self, **changes: Any) -> Status:
        return Status(**{**vars(self._status), **changes})


def _progress(line: str) -> tuple[str, float | None] | None:
    """Stage and part of a line of `--progress json`; None for any other line."""
    if not line.startswith("{"):
        return None
    try:
        said = json.loads(line)
        part = said["part"]
        return str(said["stage"]), None if part is None else min(max(float(part), 0.0), 1.0)
    except (ValueError, LookupError, TypeError):
        return None


def _with_package(environment: Mapping[str, str]) -> str:
    """PYTHONPATH with the folder of this package, which `-P` would not find in a bare clone."""
    own = str(Path(__file__).parents[2])
    return os.pathsep.join(filter(None, (own, environment.get("PYTHONPATH"))))


def _signal(process: "subprocess.Popen[bytes]", which: int) -> None:
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, which)  # its own children too
