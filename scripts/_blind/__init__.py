"""Program of scripts/blind, for a sealed trial: make it, score it, carry it out from end to end,
or let it grow.

make_and_score     the commands `make` and `score`
pool               the command `pool`: a trial that grows, a line of a ledger for each rig
run                the command `run`: make, diagnose and score, resumably
"""
