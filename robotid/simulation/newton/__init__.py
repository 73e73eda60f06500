"""Newton's method over whole windows of samples.

Read in this order: `block_bidiagonal` (the one banded solve), `chunked_responses` (the same for many inputs at once),
`problem` (what is simulated), `solver` (`TrajectoryNewton`, a solver class for scipy's solve_ivp, and `integrate`).
"""
