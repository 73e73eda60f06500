"""How p-values are distributed where nothing is hidden: `python -m study.calibration --help`."""
