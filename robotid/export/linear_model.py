"""A fitted model for control design: state space of its linearisation, and its parameters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from robotid import __version__
from robotid.catalogue import assemble
from robotid.estimate.result import Estimate, FitResult
from robotid.export.write import Columns, Tree
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.linear import LinearJoint, linearise
from robotid.model.units import on_axis

ANGLES, SPEEDS = ("phi_m", "phi_a", "phi_b"), ("dphi_m", "dphi_a", "dphi_b")
CONTINUOUS = "dx/dt = A x + B u, y = C x + D u, about the operating point; dry friction is constant there"
WITHOUT_CHANNELS = "; channels on torque and sensors are not part of A to D"


def model_tree(fit: FitResult, speed: float, sampling_times: Mapping[str, float]) -> Tree:
    """One model linearised about a motor speed [rad/s], as `linearise` does, and all that the fit found.

    sampling_times [s] : of the records that it was fitted to, where known.
    """
    joint = assemble(fit.structure, angle=True)  # the angle is an output
    theta = np.array([fit[name].value for name in joint.names])
    linear = linearise(joint, theta, speed)
    called = on_axis(linear=fit.structure.linear)
    C, D = _outputs(joint, linear)
    channels = tuple(f"{signal}.{channel.name}" for signal, channel in joint.channels)
    angles = ANGLES[: joint.masses]
    return {
        "name": fit.name,
        "made_by": f"robotid {__version__}",
        "meaning": CONTINUOUS + (WITHOUT_CHANNELS if channels else ""),
        "operating_point": {"dphi_m": speed, "unit": called("rad/s")},
        "A": linear.A,
        "B": linear.b[:, None],
        "C": C,
        "D": D,
        "state_names": joint.state_names,
        "state_units": tuple(called(_unit(name)) for name in joint.state_names),
        "input_names": ("tau_m",),
        "input_units": (called("Nm"),),
        "output_names": (*angles, *SPEEDS[: joint.masses], "ddphi_m"),
        "output_units": tuple(map(called, ["rad"] * len(angles) + ["rad/s"] * len(angles) + ["rad/s2"])),
        "mass": linear.M,
        "damping": linear.D,
        "stiffness": linear.K,
        "gear_ratio": joint.ratio,
        "effects": fit.structure.terms,
        "channels": channels,
        "parameters": _nested(fit.parameters),
        "covariance": {"names": tuple(p.name for p in fit.parameters), "robust": fit.covariance_robust},
        "records": fit.records,
        "sampling_time": dict(sampling_times),
        "fit_percent": fit.fit_percent,
    }


def parameter_columns(fit: FitResult) -> Columns:
    """Parameters of one model, a row each."""
    p = fit.parameters
    return {
        "parameter": [e.name for e in p],
        "value": np.array([e.value for e in p]),
        "std": np.array([e.std for e in p]),
        "std_robust": np.array([e.std_robust for e in p]),
        "unit": [e.unit for e in p],
        "lower": np.array([e.lower for e in p]),
        "upper": np.array([e.upper for e in p]),
        "fixed": ["yes" if e.fixed else "no" for e in p],
        "remark": [e.remark for e in p],
    }


def _outputs(joint: Joint, linear: LinearJoint) -> tuple[Array, Array]:
    """C and D for angles, speeds and motor acceleration, (2 nv + 1, nx) and (2 nv + 1, 1)."""
    nv, positions = joint.masses, joint.speeds.start
    C, D = np.zeros((2 * nv + 1, joint.nx)), np.zeros((2 * nv + 1, 1))
    C[:nv, :positions] = np.linalg.inv(joint.positions)
    C[nv : 2 * nv, joint.speeds] = np.eye(nv)
    C[-1], D[-1] = linear.A[linear.motor], linear.b[linear.motor]
    return C, D


def _unit(state: str) -> str:
    return "rad/s" if state in SPEEDS else "rad" if state in (*ANGLES, "twist", "link_twist") else ""


def _nested(parameters: tuple[Estimate, ...]) -> dict[str, Any]:
    """Parameters by port, effect and symbol."""
    tree: dict[str, Any] = {}
    for p in parameters:
        *path, symbol = p.name.split(".")
        branch = tree
        for name in path:
            branch = branch.setdefault(name, {})
        branch[symbol] = {
            "value": p.value,
            "std": p.std,
            "std_robust": p.std_robust,
            "unit": p.unit,
            "lower": p.lower,
            "upper": p.upper,
            "fixed": p.fixed,
        }
    return tree
