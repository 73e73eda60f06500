"""A MATLAB function with the equations of motion of the nonlinear model."""

from __future__ import annotations

import re
from collections.abc import Sequence

from robotid.export.equations.code import MATLAB
from robotid.export.handover.function import FunctionBody, Spelling, cannot_be_written, function_body
from robotid.export.handover.handed_model import HandedModel
from robotid.export.handover.target import Target


class MatlabFunction(Target):
    """The equations of motion as a function for ode15s, Simulink or a block of its own, without a toolbox."""

    name = "matlab_function"
    suffix = ".m"
    summary = "a MATLAB function with the equations of motion"

    def omitted(self, model: HandedModel) -> dict[str, str]:
        return cannot_be_written(model)

    def text(self, model: HandedModel, comment: Sequence[str]) -> str:
        body = function_body(model, MATLAB, SPELLING)
        return TEMPLATE.format(
            name=model.file_stem,
            head="\n".join(f"% {line}" for line in comment),
            states=", ".join(f"'{name}'" for name in body.states),
            ratio=repr(model.fit.structure.gear_ratio or 1.0),
            parameters="\n".join(f"    d.{_field(name)} = {value!r};" for name, value in body.parameters.items()),
            smoothing=" ".join(map(repr, body.smoothing)),
            lines="\n".join(body.lines),
            accelerations=_accelerations(body),
            rates="; ".join(body.rates),
        )


def _field(name: str) -> str:
    """A dotted name as one of a struct's field."""
    return re.sub(r"\W", "_", name)


SPELLING = Spelling(lambda name: f"p.{_field(name)}", lambda k: f"x({k + 1})", lambda j: f"smoothing({j + 1})")


def _accelerations(body: FunctionBody) -> str:
    if body.diagonal:
        return "\n".join(f"a{j} = force{j} / {m};" for j, m in enumerate(body.mass_diagonal))
    rows = "; ".join(", ".join(row) for row in body.mass)
    lines = [f"a = [{rows}] \\ [{'; '.join(f'force{j}' for j in range(len(body.mass)))}];"]
    return "\n".join([*lines, *(f"a{j} = a({j + 1});" for j in range(len(body.mass)))])


TEMPLATE = """function dx = {name}(t, x, torque, p)
{head}
%
% dx = {name}(t, x, torque) are the rates of the states x at a time t [s] under a motor torque, in SI, angles of the
% motor in radians on its own side of the gear. States: {states}.
% p = {name}() are the parameters, to be changed and given as the fourth argument; gear ratio {ratio}.
%
%   u = @(t) interp1(time, torque, t, 'previous', 'extrap');
%   [t, x] = ode15s(@(t, x) {name}(t, x, u(t)), time, x0, odeset('MaxStep', time(2) - time(1)));

if nargin < 4
    d = struct();
{parameters}
    if nargin == 0
        dx = d;
        return
    end
    p = d;
end
smoothing = [{smoothing}]; % speed of each coordinate below which dry friction grows with the speed
{lines}
{accelerations}
dx = [{rates}];
end

function y = pick(condition, yes, no)
if condition
    y = yes;
else
    y = no;
end
end
"""
