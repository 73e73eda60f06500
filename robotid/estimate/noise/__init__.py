"""The noise of a simulation's residual, by the places where it arises.

Read `response` (how a torque error shows in the output), `whitening` (the filter that a noise asks for) and `levels`
(how much of each noise a residual shows).
"""
