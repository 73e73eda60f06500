"""Configurations of a virtual robot whose axes move together: the two axes of `coupled_axes`, and three rigid ones."""

from __future__ import annotations

TWO = """\
robot:
  name: arm
  axes:
    a1:
      gear_ratio: 0.01
      model: &joint {motor: [inertia, viscous, coulomb], gear: [spring, damper], arm: [inertia]}
      plant:
        parameters:
          motor.inertia.J: 0.001
          motor.viscous.Fv: 0.002
          motor.coulomb.Fc: 0.2
          gear.spring.k1: 3.0e+4
          gear.damper.d: 30
          arm.inertia.J: 1
        controller: {kind: speed, kp: 0.05, ki: 0.5}
    a2:
      gear_ratio: 0.0125
      model: *joint
      plant:
        parameters:
          motor.inertia.J: 0.0006
          motor.viscous.Fv: 0.001
          motor.coulomb.Fc: 0.15
          gear.spring.k1: 1.2e+4
          gear.damper.d: 10
          arm.inertia.J: 0.3
        controller: {kind: speed, kp: 0.03, ki: 0.3}
records:
  - name: one
    pose: {a2: 0.5}
    excite:
      {kind: triangle, period: 0.4, sampling_time: 0.001, axes: {a1: {amplitude: 20}, a2: {amplitude: 25}}}
  - name: two
    role: validate
    excite:
      kind: multisine
      band: [5, 30]
      period: 0.4
      crest_factor: null
      sampling_time: 0.001
      axes:
        a1: {peak: 20}
        a2: {peak: 25, band: [5, 40]}
plant:
  body: {links: [{mass: 20, length: 0.5, centre: 0.25, inertia: 0.5}, {mass: 10, centre: 0.2, inertia: 0.2}]}
  seed: 3
"""

_MOTOR = "{motor.inertia.J: 0.001, motor.viscous.Fv: 0.002, motor.coulomb.Fc: 0.1}"
_AXIS = f"""\
      gear_ratio: 0.02
      model: {{motor: [inertia, viscous, coulomb]}}
      plant: {{parameters: {_MOTOR}, controller: {{kind: speed, kp: 0.05, ki: 0.5}}}}
"""
THREE = f"""\
robot:
  name: arm
  axes:
    a1:
{_AXIS}    a2:
{_AXIS}    a3:
{_AXIS}records:
  - name: one
    excite:
      kind: sum
      sampling_time: 0.002
      periods: 2
      realisations: 3
      orthogonal: true
      of: [{{kind: multisine, band: [2, 40], period: 0.5, peak: 10, crest_factor: null}}]
plant:
  body:
    gravity: 9.81
    links: [{{mass: 5, length: 0.4, centre: 0.2, inertia: 0.1}}, {{mass: 3, length: 0.3, centre: 0.1, inertia: 0.05}},
            {{mass: 1, centre: 0.1, inertia: 0.01}}]
"""

EXPERIMENTS = (
    TWO[: TWO.index("records:")]
    + """\
records:
  - name: turning
    use: rigid
    pose: {a2: 0.8}
    excite:
      {kind: triangle, period: 1, sampling_time: 0.002, axes: {a1: {amplitude: 30}, a2: {amplitude: 40}}}
  - name: wide
    use: flex
    pose: {a1: 0.3, a2: 1.0}
    excite:
      kind: sum
      periods: 3
      sampling_time: 0.002
      realisations: 2
      orthogonal: true
      axes:
        a1:
          of:
            - &sines {kind: multisine, band: [3, 40], period: 2, peak: 8, crest_factor: null}
            - &turn {kind: square, amplitude: 15, period: 1}
        a2: {of: [*sines, *turn]}
plant:
  body: {links: [{mass: 20, length: 0.5, centre: 0.25, inertia: 0.5}, {mass: 10, centre: 0.2, inertia: 0.2}]}
  noise: {torque: 0.0004, speed: 0.002}
  seed: 3
"""
)
"""The two axes, once turning far, and in two orthogonal experiments about a pose."""
