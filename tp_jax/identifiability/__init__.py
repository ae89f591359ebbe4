"""Identifiability of parameters: from any data of this kind, and from these.

design                               an experiment: drive, start, times
log_derivatives, rank                the sensitivity matrix; structural identifiability
null_directions                      combinations that can change unseen, in few parameters
information                          information matrix, correlations, weak combinations of a fit
copies, profile_likelihood           batched refits; profiles and their intervals
"""
