"""Writes the example records of this folder, as drives would log them: the paper's experiment on the virtual robot, and
two days of a motor.

Run from the project's root: python data/make_example.py
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from robotid.config.load import load
from robotid.model.array import Array
from robotid.signals.record import Record
from robotid.stages.collect import collect
from robotid.stages.excite import excite

HERE = Path(__file__).parent
COLUMNS: Mapping[str, tuple[str, Callable[[Record], Array]]] = {
    "time [s]": ("%.4f", lambda record: record.t),
    "torque [Nm]": ("%.3f", lambda record: record.tau_m),
    "angle [deg]": ("%.4f", lambda record: np.rad2deg(record.phi_m)),
    "speed [deg/s]": ("%.1f", lambda record: np.rad2deg(record.dphi_m)),
    "reference [rad/s]": ("%.3f", lambda record: np.asarray(record.ref)),
}
"""By head: how a number is written, and where it comes from."""
PLANTS = {"example_plant.yaml": list(COLUMNS), "motor_plant.yaml": list(COLUMNS)[:3]}
"""What made records, and which columns of these are logged."""


def write(record: Record, heads: list[str]) -> None:
    """One record as CSV, in the units that drives log."""
    table = np.stack([COLUMNS[head][1](record) for head in heads], axis=1)
    formats = [COLUMNS[head][0] for head in heads]
    path = HERE / f"{record.name}.csv"
    np.savetxt(path, table, fmt=formats, delimiter=",", header=",".join(heads), comments="")


def main() -> None:
    for plant, heads in PLANTS.items():
        settings = load(HERE / plant).config
        for record in collect(settings, excite(settings), {}).records:
            write(record, heads)


if __name__ == "__main__":
    main()
