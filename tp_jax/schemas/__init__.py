"""Schemas of files that are read back, and sentences about where one does not fit.

checking       JSON and TOML; a value against a schema -> one sentence that names the field
parts          numbers, texts, tables and lists, of which schemas are made
starts         a search to go on from
recording      FILE.csv.meta.json
calibration    a calibration of the sensors, as TOML
exploring      what an exploration goes on from
"""
