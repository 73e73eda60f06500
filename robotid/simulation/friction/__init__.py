"""One implicit step for every sampling interval at once, with dry friction exact inside the step.

Read in this order: `step` (what a step starts from, and what it yields), `mode` (slipping or sticking), `regular_step`
(Hermite-Simpson in one mode), `crossing` (reversals and other switching surfaces inside an interval, and
`linearise_steps`, which the solver and the sensitivities call).
"""
