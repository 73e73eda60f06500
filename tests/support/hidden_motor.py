"""A virtual motor with one effect more than its model has, and logs of it as a drive would write them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from robotid.config.load import load
from robotid.stages.collect import collect
from robotid.stages.excite import excite

MACHINE = """
robot: {name: axis, model: {motor: [inertia, viscous, coulomb]}}
records:
  - name: log
    excite:
      kind: sum
      sampling_time: 0.002
      of:
        - {kind: multisine, band: [0.5, 10], period: 4, peak: 6, crest_factor: 1.6}
        - {kind: triangle, amplitude: 12, period: 4}
  - name: day2
    role: validate
    excite:
      kind: sum
      sampling_time: 0.002
      of:
        - {kind: multisine, band: [0.5, 8], period: 4, peak: 8, crest_factor: 1.6, seed: 5}
        - {kind: square, amplitude: 5, period: 4}
plant:
  model: {motor: [inertia, viscous, coulomb, %s]}
  parameters: {motor.inertia.J: 0.012, motor.viscous.Fv: 0.013, motor.coulomb.Fc: 0.6, %s}
  controller: {kind: speed, kp: 0.5, ki: 5}
  encoder: {counts_per_rev: 65536}
  noise: {torque: 0.005}
  seed: 1
"""


def motor_with(effect: str, **parameters: float) -> str:
    """The configuration of a motor with this effect, and of the model without it."""
    return MACHINE % (effect, ", ".join(f"motor.{effect}.{symbol}: {value}" for symbol, value in parameters.items()))


def write_logs(folder: Path, machine: str) -> None:
    """Write log.csv and day2.csv: time, torque and angle in degrees."""
    path = folder / "machine.yaml"
    path.write_text(machine)
    settings = load(path).config
    for record in collect(settings, excite(settings), {}).records:
        columns = np.column_stack([record.t, record.tau_m, np.rad2deg(record.phi_m)])
        head = "time [s],torque [Nm],angle [deg]"
        np.savetxt(folder / f"{record.name}.csv", columns, delimiter=",", header=head, comments="", fmt="%.6g")
