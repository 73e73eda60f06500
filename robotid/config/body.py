"""The body of the robot: how its axes sit, what is known of its masses, and which signals are theirs."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from robotid.body.chain import STANDARD_GRAVITY
from robotid.config.section import Finite, Name, Positive, Section

Factor = Annotated[float, Field(gt=1, allow_inf_nan=False)]


class DhRowSettings(Section):
    """One axis by Denavit and Hartenberg, from the base on.

    d [m] : offset along the axis. a [m] : length of the link. alpha : twist of the link, in the unit of the rows. theta
    : angle at which the recorded one is zero, in the unit of the rows. sign : -1 where the recorded angle turns the
    other way.
    """

    d: Finite = 0.0
    a: Finite = 0.0
    alpha: Finite = 0.0
    theta: Finite = 0.0
    sign: Literal[1, -1] = 1


class BodyAxisSettings(Section):
    """Where the records have an axis; nothing of the joint itself.

    angle : signal of its angle behind the gear, of kind angle. torque : signal of its motor's torque, of kind drive.
    gear_ratio : phi_a / phi_m.
    """

    angle: Name | None = None
    torque: Name | None = None
    gear_ratio: Finite = 1.0


class BodySettings(Section):
    """The links of a robot, identified at once from the torques of all axes: by `urdf` or by `dh`.

    urdf : a file beside the configuration. dh : a row for each axis. convention : of the rows of dh; distal is the
    standard one, proximal that of Craig. unit : of alpha and theta in dh. gravity [m/s2] : in the frame of the base.
    joints : the URDF's joint of each axis, absent: of the same name. masses : of a URDF, where the estimate starts, or
    fixed. rotors [kg m2] : of the motors before their gears, by axis, where they are known. friction : of every drive,
    beside the bodies. mass_factor : by which the mass of a link, or the inertia of a rotor, may well differ from a
    start that is a guess. given_factor : the same, from a start that is given. cutoff [Hz] : of the zero-phase filter,
    absent: chosen from the motion. axis : which one this joint is; a robot with several axes fills it in. axes : the
    signals of all of them, from the base on, filled in likewise.
    """

    urdf: str | None = None
    dh: Annotated[tuple[DhRowSettings, ...], Field(min_length=1)] | None = None
    convention: Literal["distal", "proximal"] = "distal"
    unit: Literal["rad", "deg"] = "rad"
    gravity: tuple[Finite, Finite, Finite] = (0.0, 0.0, -STANDARD_GRAVITY)
    joints: dict[Name, str] = {}
    masses: Literal["start", "fixed"] = "start"
    rotors: dict[Name, Positive] = {}
    friction: tuple[Literal["viscous", "coulomb", "asymmetric", "offset"], ...] = ("viscous", "coulomb", "offset")
    mass_factor: Factor = 10.0
    given_factor: Factor = 2.0
    cutoff: Positive | None = None
    axis: Name
    axes: Annotated[dict[Name, BodyAxisSettings], Field(min_length=1)]

    @model_validator(mode="after")
    def _one_description(self) -> Self:
        if (self.urdf is None) == (self.dh is None):
            raise ValueError("a body needs either urdf or dh" + ("" if self.urdf is None else ", not both"))
        if self.dh is not None and len(self.dh) != len(self.axes):
            raise ValueError(f"{len(self.dh)} rows of dh for {len(self.axes)} axes; give one a row, from the base on")
        if self.axis not in self.axes:
            raise ValueError(f"axis {self.axis} is none of {', '.join(self.axes)}")
        for key, named in (("joints", self.joints), ("rotors", self.rotors)):
            if unknown := [name for name in named if name not in self.axes]:
                raise ValueError(f"{key} names {unknown[0]}, which is none of {', '.join(self.axes)}")
        for name, one in self.axes.items():
            if name != self.axis and (one.angle is None or one.torque is None):
                raise ValueError(f"axis {name} needs angle and torque: the names of its signals in the records")
        return self
