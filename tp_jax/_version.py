"""The version of tp_jax, kept here; a test holds CITATION.cff to it."""

__version__ = "0.2.0"
