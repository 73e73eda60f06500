"""The robot section: which effects act where, and what is known of their parameters beforehand."""

from __future__ import annotations

from dataclasses import replace
from typing import Self

from pydantic import field_validator, model_validator

from robotid.config.body import BodySettings
from robotid.config.section import Finite, Name, Section
from robotid.model.parameters import KnownParameter
from robotid.model.port import Port, Signal
from robotid.model.structure import Structure, change

Effects = dict[str, tuple[str, ...]]
"""Effects by port ("motor" to "tool") and channels by signal ("torque", "angle", "speed")."""


class ParameterSettings(Section):
    """What is known of one parameter beforehand, in SI. Absent numbers are those that the effect declares.

    guess : start of the fit instead of what the initialisation found. bounds : lower and upper. fixed : not estimated,
    it keeps the guess or what the initialisation found.
    """

    guess: Finite | None = None
    bounds: tuple[float, float] | None = None
    fixed: bool = False

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.bounds is not None and not self.bounds[0] < self.bounds[1]:
            raise ValueError(f"the lower bound {self.bounds[0]:g} is not below the upper bound {self.bounds[1]:g}")
        return self


class RobotSettings(Section):
    """One joint. gear_ratio : phi_a / phi_m, needed by every effect beyond the motor. linear : the axis slides (m, N,
    kg).

    name : of the axis. model : effects by the place where they act. parameters : what is known of them beforehand.
    recorded_angle : torques that depend on the motor's angle, such as a cogging, act at the recorded angle, for that of
    an open-loop simulation drifts. changes : by record, the parameters that differ there: a payload, a warm gearbox.
    body : of all links of the robot; it adds the signals body_inertia and body_torque to the records.
    """

    name: Name
    gear_ratio: Finite | None = None
    linear: bool = False
    recorded_angle: bool = False
    model: Effects
    changes: dict[Name, tuple[str, ...]] = {}
    parameters: dict[str, ParameterSettings] = {}
    body: BodySettings | None = None

    @field_validator("gear_ratio")
    @classmethod
    def _reduces(cls, ratio: float | None) -> float | None:
        if ratio is not None and not 0 < abs(ratio) <= 1:
            turned = f"; did you mean {1 / ratio:.6g}?" if ratio else ""
            raise ValueError(f"the ratio phi_a / phi_m of a gear is at most 1, found {ratio:g}{turned}")
        return ratio

    def known(self) -> dict[str, KnownParameter]:
        """What is known of the parameters, by dotted name."""
        return {name: KnownParameter(p.guess, p.bounds, p.fixed) for name, p in self.parameters.items()}

    def structure(self, model: Effects | None = None) -> Structure:
        """The joint of `model`, by default the robot's own."""
        joint = structure_of(self.model if model is None else model, self.gear_ratio, self.linear)
        if model is not None:
            return joint
        changes = tuple(change(record, name) for record, names in self.changes.items() for name in names)
        return replace(joint, changes=changes, recorded_angle=self.recorded_angle)


def structure_of(model: Effects, gear_ratio: float | None, linear: bool) -> Structure:
    """Dotted names, port by port in the order of `Port` and `Signal`, within a port as listed."""
    return Structure(
        terms=tuple(f"{port}.{effect}" for port in Port for effect in model.get(port, ())),
        channels=tuple(f"{signal}.{effect}" for signal in Signal for effect in model.get(signal, ())),
        gear_ratio=gear_ratio,
        linear=linear,
    )
