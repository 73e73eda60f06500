"""Kills at random moments and files with random damage: what holds whatever happens.

Order of reading: `kills` (a run that is stopped, and what is left of it), `mutations` (damaged files), `__main__`
(`make chaos`: many of both within ten minutes). The gate runs a few of each.
"""
