"""What the identification of a body returns."""

from __future__ import annotations

from dataclasses import dataclass, field

from robotid.display import Displayed

INERTIA, TORQUE = "body_inertia", "body_torque"
"""Companions that the body adds to each record: by how much the axis' own inertia differs from its mean, and the torque
by which gravity and the other axes drive it."""


@dataclass(frozen=True, slots=True)
class BaseParameter:
    """A combination of parameters that the torque depends on, estimated without any prior knowledge.

    name : the sum, the parameter first whose column stands for it. std : for errors as coloured as they are. seen :
    False where these motions tell it from others too poorly to be estimated at all; then value and std are nan.
    """

    name: str
    value: float = field(metadata={"unit_in": "unit"})
    unit: str
    std: float = field(metadata={"unit_in": "unit", "unbounded": True, "least": 0.0})
    seen: bool


@dataclass(frozen=True, slots=True)
class BodyParameter:
    """A parameter of a link or drive, physically consistent with the others of its link.

    start : where it was expected, nan where it was not. seen : the share of the start's variance that the data took
    away, from 0 (it keeps its start) to 1. fixed : taken as known.
    """

    name: str
    value: float = field(metadata={"unit_in": "unit"})
    unit: str
    std: float = field(metadata={"unit_in": "unit", "unbounded": True, "least": 0.0})
    start: float = field(metadata={"unit_in": "unit"})
    seen: float
    fixed: bool


@dataclass(frozen=True, slots=True)
class TorqueErrors:
    """100 ||tau - tau_hat|| / ||tau|| of a record for each axis, both filtered: by the base parameters, and by the
    consistent parameters."""

    record: str
    fitted: bool
    base: tuple[float, ...] = field(metadata={"unit": "%", "shape": ("axes",), "least": 0.0})
    consistent: tuple[float, ...] = field(metadata={"unit": "%", "shape": ("axes",), "least": 0.0})


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class BodyResult(Displayed):
    """The body of a robot, from the torques of all axes at once. axes : from the base on. cutoff : by record."""

    axes: tuple[str, ...] = field(metadata={"shape": ("axes",)})
    base: tuple[BaseParameter, ...]
    condition_number: float = field(metadata={"unbounded": True, "least": 0.0})
    parameters: tuple[BodyParameter, ...]
    errors: tuple[TorqueErrors, ...]
    cutoff: dict[str, float] = field(metadata={"unit": "Hz", "least": 0.0})
    remarks: tuple[str, ...]

    def __getitem__(self, name: str) -> BodyParameter:
        return next(p for p in self.parameters if p.name == name)
