"""Several joints that a body couples, each under its controller: the virtual robot of several axes.

Read in this order: `planar_chain` (the body), `coupled_joints` (the equations of motion of all axes), `loop` (with the
controllers), `coupled_robot` (with noisy sensors).
"""
