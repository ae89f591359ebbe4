"""Messages to the user when a command fails, and the exit code."""

import errno
import sys
import traceback

from tp_jax.errors import InputError

OF_THE_SYSTEM = {
    getattr(errno, name)
    for name in ("ENAMETOOLONG", "ELOOP", "ENOSPC", "EDQUOT", "EROFS", "EFBIG")
    if hasattr(errno, name)
}
"""Refusals of a file system that may come anywhere, and that nobody but the user can mend."""


def explain(fault: Exception, *, debug: bool) -> int:
    """Prints one sentence on standard error (with `debug` the traceback before it).

    Returns:
        2 where the input is to be mended, 1 where the fault is ours.
    """
    if debug:
        traceback.print_exception(fault)
    if isinstance(fault, InputError):  # CampaignError is one
        print(f"tp-jax: {_one_line(str(fault))}", file=sys.stderr)
        return 2
    if isinstance(fault, OSError) and fault.errno in OF_THE_SYSTEM:
        name = str(fault.filename or "")
        name = f" {name[:60]}..." if len(name) > 120 else f" {name}" if name else ""
        print(f"tp-jax: Cannot use the file{name}: {fault.strerror}.", file=sys.stderr)
        return 2
    what = _one_line(f"{type(fault).__name__}: {fault}").rstrip(".: ")
    hint = "" if debug else "; rerun with --debug for the traceback"
    print(f"tp-jax: A fault of ours, {what}{hint}.", file=sys.stderr)
    return 1


def _one_line(text: str) -> str:
    return " ".join(text.split())
