"""Machine on which numbers were measured, and when."""

import datetime
import os
import platform
from importlib import metadata
from pathlib import Path

from .peer import cores

PACKAGES = (
    "jax",
    "jaxlib",
    "diffrax",
    "equinox",
    "numpy",
    "scipy",
    "numba",
    "casadi",
    "scikit-sundae",
)


def description() -> dict:
    """Processor, cores, system, versions and date."""
    import jax

    from tp_jax._version import __version__

    device = jax.devices()[0]
    return {
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "processor": _processor(),
        "cores": cores(),
        "load": _load(),
        "system": f"{platform.system()} {platform.machine()}",
        "device": f"{device.platform}: {device.device_kind}",
        "versions": {
            "python": platform.python_version(),
            "tp-jax": __version__,
            **{name: found for name in PACKAGES if (found := _version(name))},
        },
    }


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    for line in lines:
        if line.startswith("model name"):
            return line.partition(":")[2].strip()
    return platform.processor() or "unknown"


def _load() -> float | None:
    """Programs that were waiting for a core before the start: others may have slowed this."""
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else None


def _version(name: str) -> str | None:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None
