"""Lifted Newton: a fit and the simulations that it needs are solved together (Albersmeyer & Diehl 2010).

Reading order: linearisation (steps of all records), iterate (the least-squares problem that they make), coarse (fewer
samples), engine (`solve`).
"""

from robotid.estimate.lifted.engine import fits_in_memory, solve

__all__ = ["fits_in_memory", "solve"]
