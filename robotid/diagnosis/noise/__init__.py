"""The error that no model can remove.

Order of reading: `spectrum` (a residual's spectrum as a sum of noises of known shape), `noise_floor` (noise and misfit
distinguished in a residual), `whitening` (the filter that makes noise of these levels white, and a `Segment` of a
record with its filter), `noise_estimate` (the noise that a diagnosis reckons with). `settings` holds the tuning
constants. A noise model with further shapes, such as coloured torque errors, is a further row of `Spectrum.shapes` and
its part of the whitening.
"""
