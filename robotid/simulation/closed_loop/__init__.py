"""A joint under its controller.

Read in this order: `controller`, `loop` (the simulation in closed loop), `virtual_robot` (with noisy sensors).
"""
