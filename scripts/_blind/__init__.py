"""What scripts/blind does with a sealed trial: make it, score it, or carry it out from end to end.

make_and_score     the commands `make` and `score`
run                the command `run`: make, diagnose and score, resumably
"""
