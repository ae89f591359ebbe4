"""Options of XLA for single programs, by the processor that there is."""

import functools
import os

from tp_jax._processor import features

WIDTH_OPTION = "xla_cpu_prefer_vector_width"


def loops_left_alone() -> bool:
    """True where XLA is to be given no option about loops (`TP_JAX_SMALL_LOOPS=off`)."""
    return os.environ.get("TP_JAX_SMALL_LOOPS", "").lower() == "off"


@functools.cache
def compiler_options() -> dict[str, int]:
    """Returns the options of XLA for a program of the engine's, for `jax.jit`.

    On a processor with AVX-512 (known on Linux only) it uses half the width of its registers
    unless told otherwise, since some of the older ones slow down then; a sweep takes an eighth
    less in full width. Empty elsewhere, and where `XLA_FLAGS` sets the width itself.
    """
    import jax

    own = WIDTH_OPTION in os.environ.get("XLA_FLAGS", "")
    if own or jax.default_backend() != "cpu" or "avx512f" not in features():
        return {}
    wide = {WIDTH_OPTION: 512}
    try:
        jax.jit(lambda: 0.0, compiler_options=wide).lower().compile()
    except jax.errors.JaxRuntimeError:  # this version of XLA has no such option
        return {}
    return wide
