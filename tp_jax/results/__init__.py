"""What commands find, as types: one file for each kind of result, without JAX.

encoding         a type's annotations say how it is written as JSON, read, and checked
diagnosis        diagnosis.json: `DiagnosisRecord` and its parts
"""
