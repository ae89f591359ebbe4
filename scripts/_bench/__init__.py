"""Program of scripts/bench: the engine side by side with what else one would take.

    problem, equations   the preset, its variations; the equations in plain numbers
    peer, peers/         one way to compute the same motions per file, all with the same interface
    reference            what errors are measured against, kept between runs
    timing               paired, interleaved timings; a cap on what takes too long
    measures/            one measurement per file; each returns numbers and rows of the table
    figures, table       what becomes of the numbers

`peers/ours.py` is the only file that knows how the engine is called.
"""
