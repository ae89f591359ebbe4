"""Integration of the equations of motion: one run with diffrax, many windows as lanes."""

from tp_jax.simulation.rosenbrock import Rosenbrock as Rosenbrock
from tp_jax.simulation.solve import Trajectory as Trajectory
from tp_jax.simulation.solve import simulate as simulate
