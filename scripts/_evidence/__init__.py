"""Would one log evidence decide better than today's rules? A study of saved screens.

saving      draws rigs and saves the first screen of each
screens     the form in which a screen is saved
evidence    log evidences of hypotheses, and what noise alone would make of them
comparison  the answers of both ways for every rig, counted
"""
