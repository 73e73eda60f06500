"""Drawings on axes, a module for each kind of result: `time` (signals over time), `frequency`, `parameters`,
`perturbation`, `residual`, `location` (where a misfit sits), `causes`, `gain`; `layout` makes
figures of them for a page.
"""
