"""What the figures of a report show beside the results of the stages, computed from these and from the records: `law`
(what an extension adds, along the motion), `spectrum` (what a model leaves, over frequency), `response` (models and
coherence over frequency), `profile` (intervals of
doubtful parameters), `samples` (behind a curve of the missing torque), `results` and `gather` (all of it, for a run).
"""
