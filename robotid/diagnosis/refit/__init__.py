"""A model fitted as a whole through the whitening of its records, and measured on records that served for no fit.

Order of reading: `evaluation_data` (the records, fitted and validating, with their noise), `refitted_model` (what a
refit comes to, segment by segment, and where a refit of a larger or smaller model starts), `refit` (the fit itself),
`multiple_shooting` (the fit by way of short pieces, for models that a fit of whole records slips past). `settings`
holds the tuning constants.
"""
