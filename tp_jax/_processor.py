"""Features of the processor, without asking a library that would have to be loaded."""

import functools
import hashlib
import platform
import re
from pathlib import Path

CPUINFO = Path("/proc/cpuinfo")


def features(cpuinfo: Path = CPUINFO) -> tuple[str, ...]:
    """Names of what it can do, sorted; empty where the system does not say (Linux does)."""
    try:
        text = cpuinfo.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return ()
    found = re.search(r"^(?:flags|Features)\s*:(.*)$", text, re.MULTILINE)
    return () if found is None else tuple(sorted(found[1].split()))


@functools.cache
def name() -> str:
    """Name of the kind of processor: a program compiled for one may not run on another."""
    about = platform.system(), platform.machine(), platform.processor(), features()
    return hashlib.sha256(repr(about).encode()).hexdigest()[:16]
