"""Results for other programs: `linear_model` (a fitted model for control design), `responses`, `signals`, and `write`
(MATLAB, JSON and CSV); `equations` (the nonlinear model as text of a programming language), `handover` (what another
program can express, and what it costs that it cannot) and `targets`, these programs, a file each.
`robotid.pipeline.exports` chooses what an artifact offers.
"""
