"""Results for other programs: `linear_model` (a fitted model for control design), `responses`, `signals`, and `write`
(MATLAB, JSON and CSV). `robotid.pipeline.exports` chooses what an artifact offers.
"""
