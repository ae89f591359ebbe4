"""Integration of the equations of motion: whole runs (`runs`), and many short windows (`lanes`).

`Rodas4` and `ReversalController`, method and step size for diffrax, are looked up when first used:
diffrax takes half a second to import.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from tp_jax.simulation.sensitivities import Sensitivities as Sensitivities
from tp_jax.simulation.sensitivities import sensitivities as sensitivities
from tp_jax.simulation.solve import Trajectory as Trajectory
from tp_jax.simulation.solve import simulate as simulate
from tp_jax.simulation.sweep import Sweep as Sweep
from tp_jax.simulation.sweep import sweep as sweep

if TYPE_CHECKING:
    from tp_jax.simulation.reversal_controller import ReversalController as ReversalController
    from tp_jax.simulation.rodas4 import Rodas4 as Rodas4

_WITH_DIFFRAX = {"ReversalController": "reversal_controller", "Rodas4": "rodas4"}


def __getattr__(name: str) -> Any:
    if name not in _WITH_DIFFRAX:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_WITH_DIFFRAX[name]}"), name)
