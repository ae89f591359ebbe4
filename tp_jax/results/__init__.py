"""Results of commands, as types: one file for each kind of result, without JAX.

encoding         a type's annotations say how it is written as JSON, read, and checked
sizes            numbers with their errors
diagnosis        diagnosis.json: `DiagnosisRecord` and its parts
identification   `tp-jax identify --json`: `IdentificationRecord` and its parts
"""
