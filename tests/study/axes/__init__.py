"""What is hidden among two coupled axes: `python -m study.axes --help`.

Read `plan` (which trials), `arms` (the drawn robot and its records), `files` (what the tool receives), `trial` (one of
them) and `table` (what they come to).
"""
