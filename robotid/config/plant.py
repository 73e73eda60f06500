"""The virtual robot: true parameters, controller, encoder and noise, and the body that couples several axes."""

from __future__ import annotations

from math import pi
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from robotid.config.robot import Effects
from robotid.config.section import Finite, Name, NonNegative, Positive, Section


class ControllerSettings(Section):
    """The joint's controller, sampled with the record, its torque held from sample to sample: of the speed, with
    tau = kp e + ki integral(e) dt and e = ref - dphi_m, or of the position, with kpos (ref - phi_m) as the reference of
    the speed. A sliding axis reads N, m, kg.

    kind : what is controlled. kp [Nm s/rad] : of the speed. ki [Nm/rad] : of its integral. kpos [1/s] : of the
    position. limit [Nm] : clips the torque, and stops the integral. feedforward_inertia [kg m2] : of a speed
    controller, times the acceleration of the reference.
    """

    kind: Literal["speed", "position"]
    kp: Finite
    ki: Finite = 0.0
    kpos: Positive | None = None
    limit: Positive | None = None
    feedforward_inertia: NonNegative = 0.0

    @model_validator(mode="after")
    def _kpos_for_position(self) -> Self:
        if (self.kind == "position") != (self.kpos is not None):
            raise ValueError(
                "a position controller needs kpos [1/s]"
                if self.kind == "position"
                else "a speed controller has no kpos"
            )
        if self.kind == "position" and self.feedforward_inertia:
            raise ValueError("feedforward_inertia goes with a speed controller only")
        return self


class EncoderSettings(Section):
    """Resolution of the motor angle, perfect by default. quantum [rad] : smallest difference. counts_per_rev : as many
    counts a revolution instead."""

    quantum: Positive | None = None
    counts_per_rev: Annotated[int, Field(gt=0)] | None = None

    @model_validator(mode="after")
    def _one(self) -> Self:
        if self.quantum is not None and self.counts_per_rev is not None:
            raise ValueError("give quantum or counts_per_rev, not both")
        return self

    @property
    def step(self) -> float:
        """Smallest difference of angle [rad], zero for a perfect encoder."""
        if self.counts_per_rev is not None:
            return 2 * pi / self.counts_per_rev
        return self.quantum or 0.0


class NoiseSettings(Section):
    """Standard deviations of white noise. torque [Nm] : on what is recorded. speed [rad/s] : on what is measured."""

    torque: NonNegative = 0.0
    speed: NonNegative = 0.0


class MachineSettings(Section):
    """One joint of the virtual robot. parameters : the truth, by dotted name, in SI. controller : of the joint.
    encoder : of the motor. noise : of what is recorded. seed : of the noise."""

    parameters: dict[str, Finite]
    controller: ControllerSettings
    encoder: EncoderSettings = EncoderSettings()
    noise: NoiseSettings = NoiseSettings()
    seed: Annotated[int, Field(ge=0)] = 0


class OtherAxisSettings(MachineSettings):
    """Another axis of the virtual robot, of which nothing is identified. gear_ratio : phi_a / phi_m. model : its
    effects. parameters : the truth, by dotted name, in SI."""

    gear_ratio: Finite
    model: Effects


class LinkSettings(Section):
    """One link of the virtual robot. mass [kg] : of the link. length [m] : to the next axis. centre [m] : of mass, from
    its own axis along the line to the next one. inertia [kg m2] : about the centre of mass."""

    mass: Positive
    length: NonNegative = 0.0
    centre: Finite
    inertia: NonNegative


class PlantBodySettings(Section):
    """What couples the axes of the virtual robot: links in a plane, one behind the other, whose axes are parallel.

    links : one for each axis, from the base on. gravity [m/s2] : against the direction to which an angle of +90 degrees
    points, where an angle of zero of the first axis is level; zero where the plane itself is level. axis : which one
    this joint is; a robot with several axes fills it in. axes : the names of all of them, from the base on, filled in
    likewise. others : the truth of the other axes, filled in likewise.
    """

    links: Annotated[tuple[LinkSettings, ...], Field(min_length=1)]
    gravity: Finite = 0.0
    axis: Name
    axes: tuple[Name, ...]
    others: dict[Name, OtherAxisSettings]

    @model_validator(mode="after")
    def _whole(self) -> Self:
        if len(self.links) != len(self.axes):
            raise ValueError(f"{len(self.links)} links for {len(self.axes)} axes; give one each, from the base on")
        if set(self.axes) != {self.axis, *self.others} or self.axis in self.others:
            raise ValueError(
                f"axes are {', '.join(self.axes)}, but axis and others {', '.join((self.axis, *self.others))}"
            )
        return self


class PlantSettings(MachineSettings):
    """The virtual robot. model : its effects, by default robot.model. parameters : the truth, by dotted name, in SI.
    body : what couples it with other axes; absent: nothing."""

    model: Effects | None = None
    body: PlantBodySettings | None = None
