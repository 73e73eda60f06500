"""How often the intervals of a fit hold the truth: `python -m study.coverage --help`."""
