"""Sensitivity to parameters: which of them matter, and when.

ranges, outputs                      values to look at; motions there, from the batch engine
local, sobol, morris                 the three kinds of sensitivity, each through time
record, summary                      results as plain numbers, as a table
analysis                             all of it for a user: `tp_jax.sensitivity`

Not named after the function, which as `tp_jax.sensitivity` would hide the package or be hidden.
"""
