"""Share of 95 % intervals that hold the truth: many rigs, each simulated, fitted and asked.

rig                one rig: drawn, run with hard friction, fitted; its intervals and the truth
pool               rigs over all processors, each result kept as soon as it is there
tally              shares of intervals that held, with intervals of their own
figure             what that looks like
"""
