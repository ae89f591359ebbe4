"""The paper's two identifications again, and what they can and cannot find.

objective          (17) and the order of unknowns of Listing 1
truth              Section 5.1: the motion, its contact, its unseen directions
nelder_mead        the paper's search
free_run           gradients on the same objective
windows            gradients on short windows that grow
section_5_1, section_5_2   both sections, method by method
figures, table     what they look like
"""
