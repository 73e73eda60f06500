"""Where a model is wrong: the torque that it misses, and the variables of the motion that order it.

Order of reading: `smoother` (the smoothest input that takes a linear system along a measured output), `missing_torque`
(the torque of one segment, by it), `bins` and `location` (the torque of all segments along every variable), `summary`
(all of it for a model, with and without its causes). `settings` holds the tuning constants.
"""
