"""A Python file that simulates the nonlinear model, with nothing but numpy and scipy."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from robotid.export.equations.code import PYTHON
from robotid.export.handover.function import FunctionBody, Spelling, cannot_be_written, function_body
from robotid.export.handover.handed_model import HandedModel
from robotid.export.handover.target import Target

SPELLING = Spelling("p[{!r}]".format, "x[{}]".format, "SMOOTHING[{}]".format)


class PythonFunction(Target):
    """The equations of motion as a function, and a simulation from sample to sample."""

    name = "python_function"
    suffix = ".py"
    summary = "a Python file with the equations of motion and their simulation"

    def omitted(self, model: HandedModel) -> dict[str, str]:
        return cannot_be_written(model)

    def text(self, model: HandedModel, comment: Sequence[str]) -> str:
        body = function_body(model, PYTHON, SPELLING)
        head = "\n".join(line.replace("\\", "\\\\").replace('"""', "'''") for line in comment)
        return TEMPLATE.format(
            head=head,
            ratio=repr(model.fit.structure.gear_ratio or 1.0),
            linear=model.fit.structure.linear,
            states=_listed(map(repr, body.states)),
            parameters=_listed(f"{name!r}: {value!r}" for name, value in body.parameters.items()),
            smoothing=_listed(map(repr, body.smoothing)),
            lines="\n".join(f"    {line}" for line in body.lines),
            accelerations=_accelerations(body),
            rates=", ".join(body.rates),
            first=", ".join(body.first_state),
        )


def _accelerations(body: FunctionBody) -> str:
    """Statements that solve M ddq = force."""
    if body.diagonal:
        return "\n".join(f"    a{j} = force{j} / {m}" for j, m in enumerate(body.mass_diagonal))
    names = ", ".join(f"a{j}" for j in range(len(body.mass)))
    rows = ", ".join(f"[{', '.join(row)}]" for row in body.mass)
    forces = ", ".join(f"force{j}" for j in range(len(body.mass)))
    return f"    {names} = np.linalg.solve([{rows}], [{forces}])"


def _listed(entries: Iterable[str]) -> str:
    return "".join(f"\n    {entry}," for entry in entries) + "\n"


TEMPLATE = '''"""{head}

`derivatives` has the equations of motion in SI, angles of the motor in radians on its own side of the gear; `simulate`
integrates them for a torque that is constant from sample to sample. Only numpy and scipy are needed.

    x = simulate(t, torque, first_state(angle, speed))
    motor_speed = x[:, STATES.index("dphi_m")]
"""

from math import atan, cos, exp, log, sin, sqrt, tan, tanh  # noqa: F401

import numpy as np
from scipy.integrate import solve_ivp

GEAR_RATIO = {ratio}
SLIDES = {linear}  # m, N, kg in the place of rad, Nm, kg m2
STATES = ({states})
PARAMETERS = {{{parameters}}}
SMOOTHING = ({smoothing})
"""Speed of each coordinate below which dry friction grows with the speed, where in truth it sticks."""


def derivatives(t, x, torque, p=PARAMETERS):
    """Rates of the states x at a time t [s] under a motor torque."""
{lines}
{accelerations}
    return [{rates}]


def first_state(angle=0.0, speed=0.0):
    """States of a motor at an angle with a speed, the arm moving rigidly with it."""
    return [{first}]


def simulate(t, torque, x0=None, p=PARAMETERS):
    """States (n, nx) at evenly spaced times t (n,) under a torque (n,) that is held from sample to sample."""
    t, torque = np.asarray(t, dtype=float), np.asarray(torque, dtype=float)
    step, last = t[1] - t[0], len(t) - 1

    def rates(now, x):
        k = min(max(int((now - t[0]) / step + 1e-9), 0), last)
        return derivatives(now, x, torque[k], p)

    start = first_state() if x0 is None else x0
    found = solve_ivp(rates, (t[0], t[-1]), start, "LSODA", t, rtol=1e-7, atol=1e-9, max_step=step)
    if not found.success:
        raise ArithmeticError(found.message)
    return found.y.T


def sign(value):
    """-1, 0 or 1."""
    return float(value > 0.0) - float(value < 0.0)
'''
