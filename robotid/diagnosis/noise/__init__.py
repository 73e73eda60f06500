"""The error that no model can remove.

Order of reading: `spectrum` (a residual's spectrum as a sum of noises of known shape), `noise_floor` (noise and misfit
distinguished in a residual), `whitening` (a `Segment` of a record with the filter that makes its noise white),
`drawn` (what a noise leaves of a joint that reverses and rests), `colour` (noise of any colour, by which a cause is
judged), `noise_estimate` (the noise by which a diagnosis seeks and refits). `settings` holds the tuning constants.
Noise models live in `estimate.noise`: a further colour is a further level there.
"""
