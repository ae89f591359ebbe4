"""The version of tp_jax, kept here and nowhere else."""

__version__ = "0.1.0"
