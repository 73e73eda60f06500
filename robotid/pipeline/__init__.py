"""The stages as a pipeline. Read `stage` (what a row of the table states), `table` (every row), `run` (a configuration
in its directory), `freshness` (which artifacts are up to date), `execute` (load, run, save), then `report_page` and
`exports`, which show what the artifacts hold.

`stage` and `table` import nothing heavy: the command line reads its commands from them.
"""
