"""Handing a model over to another program.

Order of reading: `handed_model` (what is handed over), `target` (what a program can express, and what it writes),
`elements` (effects as the elements of rigid-body simulators), `cost` (what it costs on the records that some effects
are left out). A target names no effect: it takes what an effect is from the effect's own formulae and declarations.
"""
