"""Does a fleet name an effect that its rigs share and that no rig shows alone? A study.

rigs        draws fleets, saves the screen of each rig; a line of trials/shared.jsonl each
draws       fleets by chance from the saved screens, in seconds
told        counts of both, as Markdown for docs/scale.md
"""
