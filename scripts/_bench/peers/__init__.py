"""The peers, one per file; `load` gives those that are installed."""

from importlib import import_module

from ..peer import Peer

#: Module, and what it needs beyond the package's own dependencies. Ours first: it is what all
#: ratios are taken of.
MODULES = {
    "ours": None,
    "numba_dopri5": "numba",
    "casadi_cvodes": "casadi",
    "casadi_adams": "casadi",
    "sundae_cvode": "sksundae",
    "scipy_lsoda": None,
    "scipy_radau": None,
    "diffrax_tsit5": None,
    "diffrax_kvaerno5": None,
}
ALWAYS = tuple(module for module, needs in MODULES.items() if needs is None)


def load(modules: tuple[str, ...] = tuple(MODULES)) -> tuple[list[Peer], list[str]]:
    """Peers, and one sentence on each that is missing."""
    found, missing = [], []
    for module in modules:
        try:
            loaded = import_module(f".{module}", __package__)
        except ImportError as fault:
            needs = MODULES[module]
            if needs is None or (fault.name or needs).split(".")[0] != needs:
                raise  # a fault of ours, not a package that is not there
            missing.append(f"{module} is skipped: {needs} is not installed.")
        else:
            found.append(loaded.make())
    return found, missing
