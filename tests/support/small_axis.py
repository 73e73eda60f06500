"""A configuration of a small virtual axis: one record, so that every stage is quick."""

CONFIG = """\
robot: {name: axis, model: {motor: [inertia, viscous, coulomb]}}
records:
  - name: slow
    excite: {kind: triangle, amplitude: 20, period: 2, sampling_time: 0.005}
plant:
  parameters: {motor.inertia.J: 0.01, motor.viscous.Fv: 0.02, motor.coulomb.Fc: 0.5}
  controller: {kind: speed, kp: 0.5, ki: 5}
  noise: {speed: 0.01}
"""
