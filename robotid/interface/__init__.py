"""The front door: what `import robotid as rid` offers.

Order of reading: `model` (which effects act where, and what is known of them), `dataset` (records and their roles),
`reading` (a log becomes a record), `identification` (fit), `evaluation` (simulate and validate), `improvement`
(diagnose and extend), `monitoring` (compare and watch), `control_design` (a model in python-control), `files` (load
and save), `explanation` (the effects), `hints` (errors in Python's terms).
Every function takes and returns frozen objects that show themselves: `print(result)`, `result.table()`,
`result.to_frame()`, `result.plot()`.

The names are imported when they are first used, by `robotid.__getattr__`.
"""
