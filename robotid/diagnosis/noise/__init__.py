"""The error that no model can remove.

Order of reading: `whitening` (a `Segment` of a record with the filter that makes its noise white), `noise_estimate`
(the noises of output and torque beside what the catalogue explains, by the model of `estimate.noise`: a further noise
belongs there). Where more than noise is left: `spectrum` (a residual's spectrum as a sum of two noises of known shape),
`noise_floor` (noise and misfit distinguished in it). `settings` holds the tuning constants.
"""
