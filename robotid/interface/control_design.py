"""A fitted model for control design: the state space of python-control."""

from __future__ import annotations

import importlib
import warnings
from typing import TYPE_CHECKING, Any

from robotid.errors import ConfigError
from robotid.estimate.result import FitResult
from robotid.export.linear_model import model_tree
from robotid.extension import Extension

if TYPE_CHECKING:
    from control import StateSpace


def state_space(fit: FitResult | Extension, *, speed: float = 0.0) -> StateSpace:
    """The linearised model as a `StateSpace` of python-control (`pip install 'robotid[control]'`).

    fit : what `rid.fit` or `rid.extend` returned, or `rid.load` read from model.h5 or extension.h5. speed [rad/s] : of
    the motor, about which the model is linearised; dry friction is constant there, so that the model is one of motion
    in one direction.

    Input is the motor torque, outputs are the angles and speeds of all masses and the acceleration of the motor. They
    and the states bear their names, such as tau_m, dphi_m and twist, and are in SI, the motor's on its own side of the
    gear. Effects on signals, such as a delay of the torque, are no part of it; a warning names those that there are.

    Raises ConfigError where python-control is not installed, and for what is no fitted model.

    >>> import robotid as rid
    >>> from support.logs import motor_log
    >>> fit = rid.fit(rid.Model(motor=["inertia", "viscous", "coulomb"]), rid.read(motor_log(), name="log"))
    >>> joint = rid.state_space(fit)
    >>> joint.input_labels, joint.output_labels
    (['tau_m'], ['phi_m', 'dphi_m', 'ddphi_m'])
    >>> speed = joint["dphi_m", "tau_m"]
    >>> round(float(abs(speed(100j))), 2)                         # [rad/s/Nm] at 100 rad/s, about 1 / (J w)
    0.83
    """
    result = fit.fit if isinstance(fit, Extension) else fit
    if not isinstance(result, FitResult):
        hint = "give what rid.fit or rid.extend returns, or rid.load of model.h5 or extension.h5"
        raise ConfigError(f"{type(fit).__name__} is no fitted model", where="state_space", hint=hint)
    try:
        control = importlib.import_module("control")
    except ImportError as error:
        raise ConfigError("a state space needs python-control", hint="pip install 'robotid[control]'") from error
    model: dict[str, Any] = dict(model_tree(result, speed, {}))
    if model["channels"]:
        warnings.warn(f"no part of the state space: {', '.join(model['channels'])}", stacklevel=2)
    found: StateSpace = control.StateSpace(
        *(model[name] for name in "ABCD"),
        name=result.name,
        states=list(model["state_names"]),
        inputs=list(model["input_names"]),
        outputs=list(model["output_names"]),
    )
    return found
