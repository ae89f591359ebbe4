"""Blind trials: campaigns with something hidden, a sealed key, and what the diagnoses are worth.

    plan, draw, restart, projection, detectable, hiding -> case    no model: the virtual rig alone
    plan -> growing                                                an endless row of rigs
    rough, rough_runs -> rough_case -> case -> make                rigs that differ in everything
    recorder -> recorded                                           any runs, any recorder
    effects                                                        beyond the package's catalogue
    seal                                                           the key, opened late
    truth, judge, measures, sealed_runs, harm -> score, table      after every diagnosis
    schema, kept                                                   what is read back from files

A trial lies in one folder:

    case-001/{campaign.toml, run-01.csv, ...}     given
    case-001-diagnosis/diagnosis.json             written by whoever takes the trial
    sealed/key.json, sealed/case-001/             what is hidden, and runs that are never given
    KEY.sha256                                    commits to the key (`sha256sum -c KEY.sha256`)
"""

from trials.make import make as make
from trials.score import pool as pool
from trials.score import score as score
