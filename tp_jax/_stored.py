"""Functions whose traced programs are kept between runs.

JAX's persistent cache saves XLA's work and none of Python's: a program of a hundred effects is
still traced and lowered anew in every process, which takes longer than to load what was compiled
of it. So what is lowered is kept beside that cache (`_config.programs_folder`), under a name made
of all that it depends on: the package's source, the versions of JAX and Python, the processor, the
arguments' shapes and a description of the static ones. A program from elsewhere is as dangerous as
one in JAX's own cache; both lie in the user's cache folder, to which nobody else may write.
"""

import contextlib
import functools
import hashlib
import logging
import os
import platform
import threading
import time
from collections.abc import Callable, Hashable, Iterator
from pathlib import Path
from typing import Any

import jax
import jaxlib
from jax import export
from jax.core import Tracer

from tp_jax import _compiling, _processor
from tp_jax._compiler import compiler_options, loops_left_alone
from tp_jax._config import programs_folder
from tp_jax._files import replaced
from tp_jax._memory import release

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None

log = logging.getLogger(__name__)

LARGE = 0.5
"""Seconds to load or compile a program from which on it leaves much memory behind."""

HEAD = b"tp-jax/program/1\n"
"""Begins a file; then come 32 bytes, the SHA-256 of the rest."""

BEGIN = len(HEAD) + 32

COMPILERS = threading.BoundedSemaphore(2)
"""So many programs are compiled at once: the largest takes a gigabyte while it is."""


class Stored:
    """A compiled function of some static arguments, which come first, and of arrays.

    Compiled once where several threads ask at the same time, and once for all static arguments that
    are described alike: every campaign has a layout of its own, and a process that diagnoses one
    after the other would load the same programs for each and keep them all, a gigabyte a campaign.
    """

    def __init__(
        self, function: Callable[..., Any], static: int, describe: Callable[..., str | None]
    ):
        """Makes one.

        Args:
            function: of the static arguments and then pytrees of arrays.
            static: number of static arguments; they must be hashable.
            describe: of the static arguments, all that the program takes from them in addition
                to the package's own source, the same in every process; None where that cannot be
                said, and such a program is traced anew.
        """
        functools.update_wrapper(self, function)
        self.function, self.static, self.describe = function, static, describe
        self.jitted = jax.jit(function, static_argnums=tuple(range(static)))
        self._ready: dict[Hashable, Callable[..., Any]] = {}
        self._described: dict[tuple, str | None] = {}
        self._locks: dict[Hashable, threading.Lock] = {}
        self._guard = threading.Lock()

    def __call__(self, *args: Any) -> Any:
        """The function's value; traceable, and then like any jitted function."""
        static, arrays = args[: self.static], args[self.static :]
        leaves, tree = jax.tree.flatten(arrays)
        if any(isinstance(x, Tracer) for x in leaves):
            return self.jitted(*args)
        shapes = tuple((x.shape, x.dtype) for x in leaves)
        described = self._description(static)
        key = (static if described is None else described, tree, shapes)
        ready = self._ready.get(key)
        if ready is not None:
            return ready(*arrays)
        with self._guard:
            lock = self._locks.setdefault(key, threading.Lock())
        with lock:
            ready = self._ready.get(key)
            if ready is None:
                named = tuple((shape, str(kind)) for shape, kind in shapes)
                file = self._file(described, f"{tree} {named}")
                with COMPILERS, _alone(file), _compiling.noted():
                    begun = time.monotonic()
                    program = self._program(static, arrays, file)
                    # called itself, it would keep what it was lowered to
                    ready = program.lower(*arrays).compile()
                    del program
                    took = time.monotonic() - begun
                    if took > LARGE:
                        release()
                log.info("%s was ready after %.1f s", self.function.__name__, took)
                self._ready[key] = ready
        return ready(*arrays)

    def _description(self, static: tuple) -> str | None:
        """All that a program takes from its static arguments; see `describe` of the constructor."""
        if static not in self._described:
            self._described[static] = self.describe(*static)
        return self._described[static]

    def _file(self, described: str | None, shapes: str) -> Path | None:
        """Returns the file in which the trace is kept; None if it is not."""
        folder = programs_folder()
        if folder is None or described is None:
            return None
        about = (
            self.function.__qualname__,
            described,
            shapes,
            source_digest(),
            jax.__version__,
            jaxlib.version.__version__,
            jax.default_backend(),
            os.environ.get("XLA_FLAGS", ""),
            loops_left_alone(),
            platform.python_version(),
            _processor.name(),
            jax.config.read("jax_enable_x64"),
        )
        digest = hashlib.sha256(repr(about).encode()).hexdigest()
        return folder / f"{self.function.__name__}-{digest}"

    def _program(self, static: tuple, arrays: tuple, file: Path | None) -> Any:
        """The jitted function of the arrays, its trace kept or taken from where it was kept."""
        wide = compiler_options()
        plain = jax.jit(functools.partial(self.function, *static), compiler_options=wide)
        if file is None:
            return plain
        exported = _kept(file)
        if exported is None:
            try:
                exported = export.export(jax.jit(functools.partial(self.function, *static)))(
                    *arrays
                )
            except Exception as fault:  # there is another way
                log.info("%s is not kept: %s", file.name, fault)
                return plain
            _keep(file, exported)
        return jax.jit(exported.call, compiler_options=wide)


@contextlib.contextmanager
def _alone(file: Path | None) -> Iterator[None]:
    """Keeps other processes from compiling the same program meanwhile: they wait and find it.

    Where locks cannot be had, several compile it; none is wrong.
    """
    if file is None or fcntl is None:
        yield
        return
    lock = file.with_name(f".{file.name}.lock")
    with contextlib.ExitStack() as stack:
        with contextlib.suppress(OSError):
            held = stack.enter_context(lock.open("w"))
            fcntl.flock(held, fcntl.LOCK_EX)  # goes with the process, however that ends
            stack.callback(lock.unlink, missing_ok=True)
        yield


def _kept(file: Path) -> export.Exported | None:
    """The program in a file; None, and no file, where there is none to be had from it."""
    try:
        content = file.read_bytes()
        head, digest, program = content[: len(HEAD)], content[len(HEAD) :][:32], content[BEGIN:]
        if head != HEAD or hashlib.sha256(program).digest() != digest:
            raise ValueError("it is not as it was written")
        exported = export.deserialize(bytearray(program))
        os.utime(file)  # what was used last is kept longest
        return exported
    except FileNotFoundError:
        return None
    except Exception as fault:
        log.info("%s is made anew: %s", file.name, fault)
        with contextlib.suppress(OSError):
            file.unlink()
        return None


def _keep(file: Path, exported: export.Exported) -> None:
    try:
        program = exported.serialize()
        with replaced(file) as part:  # whole for whoever else reads or writes it
            part.write_bytes(HEAD + hashlib.sha256(program).digest() + program)
    except Exception as fault:  # a full disk, or a part of the program that has no form in a file
        log.info("%s is not kept: %s", file.name, fault)


@functools.cache
def source_digest() -> str:
    """Digest of the package's source."""
    root = Path(__file__).parent
    digest = hashlib.sha256()
    for file in sorted(root.rglob("*.py")):
        digest.update(file.relative_to(root).as_posix().encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()
