"""What every effect of the catalogue would explain of a misfit, without a refit.

Order of reading: `candidate` (what a candidate is: its columns, where its refit starts, how its shapes are refined),
`term_candidate`, `channel_candidates` and `record_change_candidate` (its kinds), `catalogue_candidates` (all that a
model could lack), `columns` (what each would add to the output, by one banded solve a record), `scan` (a record with
all columns), `projection` (all records at once, on the complement of what the fit has shaped), `score_test` (the score
of each candidate, and its significance), `confounding` (what else answers like one), `periods` and `resonances` (shapes
between the points of any grid, read off the misfit), `ranking` (one round of it).
`settings` holds the tuning constants.
"""
