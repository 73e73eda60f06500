"""The commented configuration that `robotid new` writes."""

from __future__ import annotations

from collections.abc import Sequence
from string import Template

_HEAD = Template("""\
# $name: what is to be identified, from which records.
#
#     $run every stage that is not up to date
#     $status what is fresh, stale or absent
#     $explain all effects; `robotid explain coulomb` tells of one
#
# Numbers are SI; angles, speeds and torques are on the motor side unless an effect stands at the arm.
""")

_RIGID = Template("""
robot:
  name: $name
$kind  model:                           # effects by port
    motor: [inertia, viscous, coulomb]
    # gear: [spring, damper]       # a flexible gear needs a gear_ratio above and inertia at the arm
    # arm: [inertia]
    # torque: [torque_delay]       # effects on signals: torque, angle, speed
  # parameters:                    # what is known beforehand; the rest is found
  #   motor.inertia.J: {guess: 0.01, bounds: [0.001, 0.1], fixed: false}
""")

_TURNING = """\
  # gear_ratio: 0.01               # phi_a / phi_m, such as 1/100; needed by every effect beyond the motor
  # linear: true                   # for an axis that slides: m, N, kg for rad, Nm, kg m2
"""

_LINEAR = """\
  linear: true                     # the axis slides: m, N, kg for rad, Nm, kg m2
"""

_FLEXIBLE = Template("""
robot:
  name: $name
  gear_ratio: 0.0044583147         # phi_a / phi_m, here 1/224.3; needed by every effect beyond the motor
  model:                           # effects by port
    motor: [inertia, viscous, coulomb]
    gear: [spring, damper]
    arm: [inertia]
    # torque: [torque_delay]       # effects on signals: torque, angle, speed
  # parameters:                    # what is known beforehand; the rest is found
  #   gear.spring.k1: {guess: 1.0e6, bounds: [1.0e4, 1.0e8], fixed: false}
""")

_MEASURED = Template("""
records:
  - name: $record
    role: estimate                 # or validate: held out of every fit
    # use: rigid                   # which initialisation it serves: rigid (slow, wide), flex (rich), both
    $path # relative to this file; .csv .tsv .lvm .jsonl .mat .h5 .npz
$columns
  # - name: second                 # a record that no fit has seen tells what the model is worth
  #   role: validate
  #   file: second.csv

# controller: {kind: position, kpos: 20.0, kp: 0.5, ki: 5.0}   # if known, validate also simulates the closed loop
""")

_VIRTUAL = """
records:                           # experiments on the virtual robot below. For measured data give, instead of excite,
                                   #   file: data/day1.csv
                                   #   columns: {t: time_s, tau_m: torque, phi_m: {name: angle, unit: deg}}
  - name: slow
    use: rigid                     # which initialisation it serves: rigid (slow, wide), flex (rich), both
    excite: {kind: triangle, amplitude: 40.0, period: 5.0, duration: 6.25, sampling_time: 0.001}
  - name: rich
    use: flex
    excite:
      kind: sum
      sampling_time: 0.001
      of:
        - {kind: multisine, band: [1.0, 40.0], period: 5.0, peak: 8.0}
        - {kind: square, amplitude: 10.0, period: 5.0}
  - name: held_out
    role: validate                 # held out of every fit: it tells what the model is worth
    excite:
      kind: sum
      sampling_time: 0.001
      of:
        - {kind: multisine, band: [1.0, 40.0], period: 5.0, peak: 5.0, seed: 2}
        - {kind: triangle, amplitude: 20.0, period: 2.5}

plant:                             # the virtual robot; leave it out when every record has a file
  # model: {...}                   # its effects, where they differ from robot.model
  parameters:                      # the truth
    motor.inertia.J: 0.0121
    motor.viscous.Fv: 0.0130
    motor.coulomb.Fc: 0.644
    gear.spring.k1: 1.46e+6
    gear.damper.d: 2.63e+3
    arm.inertia.J: 1130.0
  controller: {kind: speed, kp: 0.5, ki: 5.0}
  encoder: {counts_per_rev: 65536}
  noise: {torque: 0.005, speed: 0.02}
  seed: 1
"""

_REST = Template("""
# All of the following may be left out; these are the defaults, but for the threshold.
# init_rigid:
#   cutoff: null                   # of the low-pass filter [Hz]; chosen from the data when null
#   order: 4
#   min_speed: 0.0                 # slower samples [rad/s] are left out
# init_flex:
#   band: null                     # such as [1.0, 40.0] in Hz; the excitation's own when null
# fit:
#   output: null                   # speed or position; when null speed, also where it is derived from the angle
#   models:                        # each fitted to the records that it names
#     m1: [$fitted]
#   best: m1                       # the model that later stages use
#   fix: []                        # parameters that keep what the initialisation found
# validate:
#   perturbation: 20.0             # percent of each parameter
#   thresholds:                    # fit in percent, below which validate ends with exit code 5
#     fit_percent: {$threshold: 90.0}
# diagnose:
#   min_improvement_sigma: 0.1     # noise standard deviations that a cause must remove where it was not fitted
#   max_causes: 4
#   max_refits: 5                  # effects refitted for each
#   skip: []                       # effects that are out of the question
# extend:
#   effects: null                  # such as [motor.stribeck]; the causes that diagnose named when null
""")


def virtual(name: str, file: str) -> str:
    """A configuration with a virtual robot, which runs as it is."""
    return _head(name, file) + _FLEXIBLE.substitute(name=name) + _VIRTUAL + _rest(("slow", "rich"))


def measured(name: str, file: str, path: str, record: str, columns: str, *, linear: bool) -> str:
    """A configuration of a rigid axis for one measured file. columns : the YAML that says what is in it; linear : the
    axis slides."""
    records = _MEASURED.substitute(path=f"file: {path}".ljust(30), record=record, columns=columns)
    robot = _RIGID.substitute(name=name, kind=_LINEAR if linear else _TURNING)
    return _head(name, file) + robot + records + _rest((record,))


def _head(name: str, file: str) -> str:
    commands = {"run": f"robotid run {file}", "status": f"robotid status {file}", "explain": "robotid explain"}
    width = max(map(len, commands.values())) + 3
    return _HEAD.substitute({key: command.ljust(width) for key, command in commands.items()}, name=name)


def _rest(records: tuple[str, ...]) -> str:
    return _REST.substitute(fitted=", ".join(records), threshold=records[-1])


def several(name: str, columns: Sequence[str]) -> str:
    """What describes all axes of a file, as comments at the end of the configuration of one. columns : of each axis, as
    YAML on one line."""
    axes = "".join(f"#     a{k}:\n{_JOINT}#       columns: {one}\n" for k, one in enumerate(columns, 1))
    return f"""
# The file holds torque and angle of {len(columns)} axes. To identify all of them, each with the angles of the others,
# put this in the place of robot above, and leave of the columns of the record only the time:
#
# robot:
#   name: {name}
#   axes:
{axes}"""


_JOINT = """\
#       gear_ratio: 0.01               # phi_a / phi_m of the axis
#       model: {motor: [inertia, viscous, coulomb]}
"""
