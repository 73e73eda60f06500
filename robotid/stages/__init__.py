"""The stages, a function each: it takes the configuration and the contents of earlier stages, and returns its content.

A stage opens no file and prints nothing. It turns sections of the configuration into the arguments of functions of the
rooms below, which do the work and can be called without a configuration. `robotid.pipeline.table` has a row for each
stage; `experiments` serves `diagnose`.
"""
