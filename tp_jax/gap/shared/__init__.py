"""Effects that rigs of one kind share: scores and information of their screens, added over rigs.

scores               what a rig's screen says of every effect, and the file that keeps it
from_screen          the same of a diagnosis' first screen
pooling              one effect over all rigs: amplitude, reduction, agreement of the rigs
selection            which effects pass, one by one: the kind's, or some rigs' own
table                the result in plain numbers, as fleet.json has it
"""
