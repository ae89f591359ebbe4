"""Settings of JAX that the package's own entry points make, and its tests; nothing else does.

A library that is merely imported should not change JAX for everybody else. 64 bits are set when
a module that computes is first loaded (`tp_jax._float64`), since nothing in 32 would be right; all
else in the command line, or by the one call that a user makes
(`enable_compilation_cache`). JAX itself is imported inside the functions: `tp-jax --help` does not
wait for it.

Four environment variables matter:

`XLA_FLAGS`
    A simulation is a loop as one piece of machine code, whatever is set here
    (`tp_jax.simulation.one_piece`). Its inner loops, over a few lanes each, are left as loops:
    unrolled, the whole is larger than a processor's cache of instructions and takes longer to
    compile; a diagnosis takes a sixth more. And all other loops are compiled in one piece too, up
    to a limit. Both hold for all programs of the process; an `XLA_FLAGS` that sets the limit itself
    is left as it is.
`TP_JAX_SMALL_LOOPS`
    `off` leaves all loops to XLA, a simulation's too: for a version of XLA that cannot do with
    what it is told.

`EQX_ON_ERROR`
    diffrax's checks of its own results keep a compiled program out of JAX's persistent cache
    unless this is `nan` (or `off`) *before* equinox is imported. The command line sets it first
    thing, and so does `enable_compilation_cache` where equinox is not there yet. Under it a failed
    solve does not raise: it yields NaN, and the solver's result says why.
`TP_JAX_CACHE`
    `off` keeps compiled programs in memory only.
"""

import gc
import os
import sys
import warnings
from pathlib import Path

from tp_jax import _cache, _processor
from tp_jax._compiler import loops_left_alone
from tp_jax.errors import Notice

SMALL_LOOP = 16_000_000
"""Bytes that a loop may carry to count as small."""

COLLECT_AFTER = (100_000, 20, 100)
"""Objects made since the last look for unreachable ones, and looks by generation (Python's own:
700, 10, 10). Tracing a program makes millions that stay: by samples of a profile some three
hundredths of a diagnosis' CPU time went into looks. Most memory is freed without one."""

CACHED_ABOVE = 0.3
"""Seconds of compilation from which on a program is kept in the persistent cache."""


def compile_small_loops() -> None:
    """Let XLA compile large loops in one piece, and leave small ones loops (see above).

    Options of this kind that a version of XLA does not know are ignored by it.
    """
    option = "xla_cpu_small_while_loop_byte_threshold"
    flags = os.environ.get("XLA_FLAGS", "")
    if option in flags or loops_left_alone():
        return
    options = f"{option}={SMALL_LOOP},xla_cpu_disable_loop_unrolling=true"
    os.environ["XLA_FLAGS"] = f"{flags} --xla_backend_extra_options={options}".strip()


def collect_less() -> None:
    """Let Python look less often for memory that it may free: for a process of our own."""
    gc.set_threshold(*COLLECT_AFTER)


def cache_root() -> Path:
    """Returns the folder of all processors' programs between runs: in the user's cache folder.

    Raises:
        RuntimeError: there is no home to speak of.
    """
    base = os.environ.get("XDG_CACHE_HOME", "")
    # the XDG specification: a path that is not absolute counts as absent
    if os.path.isabs(base):
        return Path(base, "tp-jax")
    if not os.path.isabs(os.environ.get("HOME", "/")):  # of an empty one Python makes /
        raise RuntimeError("HOME is no folder.")
    return Path.home() / ".cache" / "tp-jax"


def cache_folder() -> Path:
    """Returns the folder where JAX keeps programs compiled for this processor."""
    return cache_root() / _processor.name() / "xla"


def enable_compilation_cache() -> bool:
    """Prepares this process for the package: programs are kept for the next one.

    The one call for scripts and notebooks; the command line does so by itself. To be made before
    anything is compiled and before equinox is imported, for what it sets holds for the whole
    process: `XLA_FLAGS`, JAX's cache, and that a simulation that fails yields NaN and says why in
    its result, where it would raise otherwise.

    Returns:
        Whether programs are kept. A folder that cannot be made or written to, or that others may
        write to (a `Notice` says so), is no reason to stop: they are then compiled anew.
    """
    compile_small_loops()
    if os.environ.get("TP_JAX_CACHE", "").lower() == "off":
        return False
    if "equinox" not in sys.modules:
        os.environ.setdefault("EQX_ON_ERROR", "nan")
    try:
        root, folder = cache_root(), cache_folder()
        for each in (root, folder.parent, folder):
            _cache.made(each)
        fault = _cache.distrusted(root, folder.parent, folder)
    except (OSError, RuntimeError):
        return False
    if fault is not None:
        warnings.warn(Notice(f"Compiled programs are not kept: {fault}."), stacklevel=2)
        return False
    if not os.access(folder, os.W_OK | os.X_OK):
        return False
    _cache.clean(root)

    import jax

    jax.config.update("jax_compilation_cache_dir", str(folder))
    jax.config.update("jax_persistent_cache_min_compile_time_secs", CACHED_ABOVE)
    jax.config.update("jax_persistent_cache_min_entry_size_bytes", 0)
    return True


def programs_folder() -> Path | None:
    """Returns the folder of traced programs (`_stored`), beside JAX's cache, where that is ours."""
    import jax

    try:
        ours = cache_folder()
        # JAX's settings are made at run time, so that its class does not tell of them
        kept = jax.config.jax_compilation_cache_dir  # pyright: ignore[reportAttributeAccessIssue]
        if kept != str(ours):
            return None
        folder = ours.with_name("programs")
        _cache.made(folder)
        return None if _cache.distrusted(folder) else folder
    except (OSError, RuntimeError):
        return None
