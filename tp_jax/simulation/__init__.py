"""Integration of the equations of motion: whole runs (`runs`), and many short windows (`lanes`).

`Rosenbrock`, the method as a diffrax solver, is looked up when first used: diffrax takes half a
second to import, and nothing else here needs it.
"""

from typing import TYPE_CHECKING, Any

from tp_jax.simulation.sensitivities import Sensitivities as Sensitivities
from tp_jax.simulation.sensitivities import sensitivities as sensitivities
from tp_jax.simulation.solve import Trajectory as Trajectory
from tp_jax.simulation.solve import simulate as simulate
from tp_jax.simulation.sweep import Sweep as Sweep
from tp_jax.simulation.sweep import sweep as sweep

if TYPE_CHECKING:
    from tp_jax.simulation.rosenbrock import Rosenbrock as Rosenbrock


def __getattr__(name: str) -> Any:
    if name == "Rosenbrock":
        from tp_jax.simulation.rosenbrock import Rosenbrock

        return Rosenbrock
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
