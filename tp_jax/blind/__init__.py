"""Blind trials: campaigns with something hidden, a sealed key, and what the diagnoses are worth.

    plan, draw, restart, projection, detectable, hiding -> case    no model: the virtual rig alone
    rough, rough_runs -> rough_case -> case -> make                rigs that differ in everything
    seal                                                           the key, opened late
    truth, judge, measures, sealed_runs, harm -> score, table      after every diagnosis

A trial lies in one folder:

    case-001/{campaign.toml, run-01.csv, ...}     given
    case-001-diagnosis/diagnosis.json             written by whoever takes the trial
    sealed/key.json, sealed/case-001/             what is hidden, and runs that are never given
    KEY.sha256                                    commits to the key (`sha256sum -c KEY.sha256`)
"""

from tp_jax.blind.make import make as make
from tp_jax.blind.score import pool as pool
from tp_jax.blind.score import score as score
