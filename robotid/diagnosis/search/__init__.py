"""The search for what a model lacks.

Order of reading: `state` (what the search knows at a time, and what it finds), `data` (the first state: the records and
the noise behind the model), `refits` (the candidates that score best, refitted in full), `acceptance` (the tests that a
cause must stand, one function each; of a `step` from a model to the next: `physical_sense` of its parameters,
`carry_over` of its gain, `coloured` beside noise of any colour, `constancy` of its size over time, `driven` by the
motion), `unexplained` (the curve that no effect explains, and causes that only imitate it), `mere_changes` (of single
records, which are none), `changed_record` and `record_changes` (what differs on validation records), `rounds` (the
causes beside one noise), `beside_curve` (causes that a curve has hidden), `events` (what happened once, set aside),
`search` (the whole algorithm), `limits` (what would have been seen).
`settings` holds the tuning constants. A further test of a cause is one more entry of `acceptance.OBJECTIONS`.
"""
