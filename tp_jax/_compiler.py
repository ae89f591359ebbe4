"""What XLA is told of single programs, by the processor that there is."""

import functools
import os
import re
from pathlib import Path

WIDTH_OPTION = "xla_cpu_prefer_vector_width"


@functools.cache
def compiler_options() -> dict[str, int]:
    """What XLA is to be told of a program of the engine's, for `jax.jit`.

    On a processor with AVX-512 (known on Linux only) it uses half the width of its registers
    unless told otherwise, since some of the older ones slow down then; a sweep takes an eighth
    less in full width. Empty elsewhere, and where `XLA_FLAGS` sets the width itself.
    """
    import jax

    own = WIDTH_OPTION in os.environ.get("XLA_FLAGS", "")
    if own or jax.default_backend() != "cpu" or not _has_avx512():
        return {}
    wide = {WIDTH_OPTION: 512}
    try:
        jax.jit(lambda: 0.0, compiler_options=wide).lower().compile()
    except jax.errors.JaxRuntimeError:  # this version of XLA has no such option
        return {}
    return wide


def _has_avx512(cpuinfo: Path = Path("/proc/cpuinfo")) -> bool:
    try:
        text = cpuinfo.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):  # not Linux
        return False
    found = re.search(r"^flags\s*:(.*)$", text, re.MULTILINE)
    return found is not None and "avx512f" in found[1].split()
