"""Results on disk. Order of reading: `provenance` (where an artifact comes from, and digests), `codec` (a dataclass as
an HDF5 group), `layout` (which fields a class has), `consistency` (whether its parts belong together), `store`
(artifacts as files that are whole or absent, and checked).
"""
