"""Settings of JAX that the package's own entry points make, and its tests; nothing else does.

A library that is merely imported should not change JAX for everybody else, so this happens when
one of the package's names that computes is first used (`tp_jax.__getattr__`), or in the command
line. JAX itself is imported inside the functions: `tp-jax --help` does not wait for it.

Three environment variables matter:

`XLA_FLAGS`
    On a CPU, XLA runs a loop operation by operation, each an own call, unless what the loop
    carries is small (a kilobyte); then it makes one piece of machine code of it. A simulation is
    such a loop, and ten times faster in one piece, so the limit is raised here, before the first
    program is compiled. Its inner loops, over a few lanes each, are left as loops too: unrolled,
    the whole is larger than a processor's cache of instructions, takes half as long again to
    compile and is no faster. Both hold for all programs of the process. `TP_JAX_SMALL_LOOPS=off`
    leaves them alone, and so does an `XLA_FLAGS` that sets the limit itself.

`EQX_ON_ERROR`
    diffrax's checks of its own results keep a compiled program out of JAX's persistent cache
    unless this is `nan` (or `off`) *before* equinox is imported. The command line sets it first
    thing, and so does `enable_compilation_cache` where equinox is not there yet. Under it a failed
    solve does not raise: it yields NaN, and the solver's result says why.
`TP_JAX_CACHE`
    `off` keeps compiled programs in memory only.
"""

import os
import sys
from pathlib import Path

SMALL_LOOP = 16_000_000
"""Bytes that a loop may carry to count as small."""

CACHED_ABOVE = 0.3
"""Seconds of compilation from which on a program is kept in the persistent cache."""


def use_float64() -> None:
    """Let JAX compute in 64 bits: at 32 the solver's error is above the sensors' noise."""
    import jax

    if not jax.config.read("jax_enable_x64"):
        jax.config.update("jax_enable_x64", True)


def compile_small_loops() -> None:
    """Let XLA compile loops as large as a simulation's in one piece (see above).

    Options of this kind that a version of XLA does not know are ignored by it.
    """
    option = "xla_cpu_small_while_loop_byte_threshold"
    flags = os.environ.get("XLA_FLAGS", "")
    if option in flags or os.environ.get("TP_JAX_SMALL_LOOPS", "").lower() == "off":
        return
    options = f"{option}={SMALL_LOOP},xla_cpu_disable_loop_unrolling=true"
    os.environ["XLA_FLAGS"] = f"{flags} --xla_backend_extra_options={options}".strip()


def cache_folder() -> Path:
    """Where compiled programs are kept between runs: the user's cache folder."""
    base = os.environ.get("XDG_CACHE_HOME", "")
    # the XDG specification: a path that is not absolute counts as absent
    home = Path(base) if os.path.isabs(base) else Path.home() / ".cache"
    return home / "tp-jax" / "xla"


def enable_compilation_cache() -> bool:
    """Keep compiled programs between runs; says whether that could be arranged.

    For scripts and notebooks; the command line does so by itself. To be called before anything
    else of the package, and before equinox is imported. A folder that cannot be made or written to
    is no reason to stop: the programs are then compiled anew. Under it a simulation that fails
    yields NaN and says why in its result, where it would raise otherwise.
    """
    if os.environ.get("TP_JAX_CACHE", "").lower() == "off":
        return False
    if "equinox" not in sys.modules:
        os.environ.setdefault("EQX_ON_ERROR", "nan")
    try:
        folder = cache_folder()
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError):  # RuntimeError: no home to speak of
        return False
    if not os.access(folder, os.W_OK | os.X_OK):
        return False

    import jax

    jax.config.update("jax_compilation_cache_dir", str(folder))
    jax.config.update("jax_persistent_cache_min_compile_time_secs", CACHED_ABOVE)
    jax.config.update("jax_persistent_cache_min_entry_size_bytes", 0)
    return True


def programs_folder() -> Path | None:
    """Where traced programs are kept (`_stored`): beside JAX's cache, where that is ours."""
    import jax

    ours = cache_folder()
    if jax.config.jax_compilation_cache_dir != str(ours):
        return None
    folder = ours.with_name("programs")
    try:
        folder.mkdir(exist_ok=True)
    except OSError:
        return None
    return folder
