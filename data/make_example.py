"""Writes the example records of this folder: the paper's experiment on the virtual robot, as a drive would log it.

Run from the project's root: python data/make_example.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from robotid.config.load import load
from robotid.signals.record import Record
from robotid.stages.collect import collect
from robotid.stages.excite import excite

HERE = Path(__file__).parent
HEADER = "time [s],torque [Nm],angle [deg],speed [deg/s],reference [rad/s]"


def write(record: Record) -> None:
    """One record as CSV, in the units that drives log."""
    columns = (record.t, record.tau_m, np.rad2deg(record.phi_m), np.rad2deg(record.dphi_m), record.ref)
    table = np.stack([np.asarray(column) for column in columns], axis=1)
    formats = ("%.4f", "%.3f", "%.4f", "%.1f", "%.3f")
    np.savetxt(HERE / f"{record.name}.csv", table, fmt=formats, delimiter=",", header=HEADER, comments="")


def main() -> None:
    settings = load(HERE / "example_plant.yaml").config
    for record in collect(settings, excite(settings), {}).records:
        write(record)


if __name__ == "__main__":
    main()
