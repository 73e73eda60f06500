"""A made-up robot of two axes, measured at the same time, and its axes as single joints."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from support.logs import motor_log

ROBOT = """\
robot:
  name: arm
  axes:
    a1:
      gear_ratio: 0.5
      model: {motor: [inertia, viscous, coulomb]}
      columns: {tau_m: torque_1, phi_m: {name: angle_1, unit: deg}}
    a2:
      model: {motor: [inertia, viscous, coulomb]}
      columns: {tau_m: torque_2, phi_m: {name: angle_2, unit: deg}}
      fit: {max_iterations: 30}
records:
  - {name: day1, file: day1.csv, columns: &time {t: time}}
  - {name: day2, role: validate, file: day2.csv, columns: *time}
diagnose: {max_refits: 1, max_causes: 1}
"""
JOINT = """\
robot: {{name: joint, {gear}model: {{motor: [inertia, viscous, coulomb]}}}}
records:
  - name: day1
    file: day1.csv
    columns: &columns {{t: time, tau_m: torque_{k}, phi_m: {{name: angle_{k}, unit: deg}}}}
    signals: &signals {{{other}}}
  - {{name: day2, role: validate, file: day2.csv, columns: *columns, signals: *signals}}
fit: {{max_iterations: {iterations}}}
diagnose: {{max_refits: 1, max_causes: 1}}
"""


def write_two_axes(folder: Path) -> None:
    """Write day1.csv and day2.csv, robot.yaml of both axes, and a1.yaml and a2.yaml of one each."""
    for day in (1, 2):
        one, two = motor_log(seed=day, duration=2.0), motor_log(seed=day + 4, duration=2.0)
        columns = [one["time"], one["torque"], one["angle_deg"], two["torque"], two["angle_deg"]]
        head = "time,torque_1,angle_1,torque_2,angle_2"
        np.savetxt(folder / f"day{day}.csv", np.column_stack(columns), "%.9g", ",", header=head, comments="")
    (folder / "robot.yaml").write_text(ROBOT)
    first = "a2: {name: angle_2, unit: deg, kind: angle}"
    second = "a1: {name: angle_1, unit: deg, scale: 0.5, kind: angle}"
    (folder / "a1.yaml").write_text(JOINT.format(gear="gear_ratio: 0.5, ", k=1, other=first, iterations=50))
    (folder / "a2.yaml").write_text(JOINT.format(gear="", k=2, other=second, iterations=30))
