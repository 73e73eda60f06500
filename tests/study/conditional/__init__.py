"""The study under other conditions than white noise, and with strangers: `python -m study.conditional --help`.

Read `plan` (which trials), `trial` (one of them) and `table` (what they come to, condition by condition).
"""
