"""Calls as they travel to a worker, and how they are carried out there.

Executors differ in how they pickle, and in what their workers can import. So a call travels as
bytes, with the folders that this process imports from, and the worker unpickles it.
"""

import functools
import importlib
import json
import pickle
import sys
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tp_jax._config import collect_less, compile_small_loops, enable_compilation_cache
from tp_jax._files import plain, replaced
from tp_jax.errors import InputError
from tp_jax.executors.processors import take_one

SCHEMA = "tp-jax/piece/1"


@dataclass(frozen=True)
class Fault:
    """Reason why a piece could not be done.

    Attributes:
        kind: name of the exception's type. text: what it says, on one line.
        of_input: whether the user can mend it: an `InputError`.
        trace: the traceback as text.
    """

    kind: str
    text: str
    of_input: bool = False
    trace: str = ""

    @classmethod
    def of(cls, fault: BaseException) -> "Fault":
        trace = "".join(traceback.format_exception(fault))
        text = " ".join(str(fault).split())
        return cls(type(fault).__name__, text, isinstance(fault, InputError), trace)

    def error(self) -> Exception:
        """An exception that says the same."""
        return InputError(self.text) if self.of_input else RuntimeError(str(self))

    def __str__(self) -> str:
        return f"{self.kind}: {self.text}"


@dataclass(frozen=True)
class Call:
    """A piece as it travels.

    Attributes:
        pickled: the work and its arguments.
        paths: where the sender imports from; a worker looks there last.
        uses_jax: whether the worker prepares JAX before it begins.
        file: gets the result as JSON, with `key` and `of`; None: the result only travels back.
    """

    pickled: bytes
    paths: tuple[str, ...]
    uses_jax: bool
    file: Path | None = None
    key: str = ""
    of: str = ""


@dataclass(frozen=True)
class Outcome:
    """Answer to a call: a result, or a fault of the work itself."""

    result: Any = None
    fault: Fault | None = None


def pickled(work: Callable[..., Any], arguments: tuple) -> bytes:
    """Work and arguments; a function of the program that was started is named by its module."""
    if work.__module__ == "__main__":
        program = sys.modules["__main__"]
        spec, file = getattr(program, "__spec__", None), getattr(program, "__file__", None)
        name = spec.name if spec is not None else Path(file).stem if file is not None else None
        if name is not None:  # else it was typed, and other processes cannot import it
            work = getattr(importlib.import_module(name), work.__qualname__)
    return pickle.dumps((work, arguments))


def carry_out(call: Call) -> Outcome:
    """Does the work, in a worker, and writes the result where it is to be kept.

    A fault of the work comes back as one, so that an exception of the future says that the worker
    is lost.
    """
    if call.file is not None:
        before = kept_result(call.file, call.key, call.of)
        if before is not None:  # another worker was faster, or died just after it was done
            return before
    sys.path += [each for each in call.paths if each not in sys.path]
    take_one()
    if call.uses_jax:
        _prepare_jax()
    try:
        work, arguments = pickle.loads(call.pickled)
        result = work(*arguments)
        if call.file is None:
            return Outcome(result)
        result = plain(result)
        kept = {"schema": SCHEMA, "key": call.key, "of": call.of, "result": result}
        text = json.dumps(kept, allow_nan=False)
        call.file.parent.mkdir(parents=True, exist_ok=True)
        with replaced(call.file) as part:
            part.write_text(text + "\n", encoding="utf-8")
        return Outcome(json.loads(text)["result"])  # as a later run reads it
    except Exception as fault:
        return Outcome(fault=Fault.of(fault))


def kept_result(file: Path, key: str, of: str) -> Outcome | None:
    """Reads what a file keeps of a piece; one spoiled or of something else keeps nothing."""
    try:
        kept = json.loads(file.read_text(encoding="utf-8"))
        if (kept["schema"], kept["key"], kept["of"]) != (SCHEMA, key, of):
            return None
        return Outcome(kept["result"])
    except (OSError, ValueError, LookupError, TypeError):
        return None


@functools.cache  # once in a process
def _prepare_jax() -> None:
    """Prepares JAX as the command line does, before anything is compiled."""
    collect_less()
    compile_small_loops()
    enable_compilation_cache()
