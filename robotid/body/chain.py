"""A serial chain of joints: where each axis sits, and what is known of the mass that it carries."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from robotid.model.array import Array

STANDARD_GRAVITY = 9.80665  # m/s2
PER_LINK = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz")
"""Inertial parameters of a link in its own frame: mass [kg], mass times centre of mass [kg m], inertia about the
frame's origin [kg m2]."""


@dataclass(frozen=True, slots=True)
class DhRow:
    """One axis by Denavit and Hartenberg, angles in rad, lengths in m.

    In the distal (standard, 1955) convention the joint turns about z of the frame before the row: Rz(theta) Tz(d) Tx(a)
    Rx(alpha). In the proximal (modified, Craig 1986) convention it turns after alpha and a: Rx(alpha) Tx(a) Rz(theta)
    Tz(d). theta : the angle at which the recorded one is zero; sign : -1 where the recorded angle turns the other way.
    """

    d: float = 0.0
    a: float = 0.0
    alpha: float = 0.0
    theta: float = 0.0
    sign: Literal[1, -1] = 1


@dataclass(frozen=True, slots=True, eq=False)
class ChainJoint:
    """One axis of a chain and the link that it carries.

    rotation (3, 3), offset (3,) [m] : frame of the link in that of the link before it, at angle zero. axis (3,) : unit
    vector of the link's frame that the joint turns about. inertia (10,) : of the link, in the order of `PER_LINK`,
    None where it is unknown. fixed : whether it is known for sure, and not estimated.
    """

    name: str
    rotation: Array
    offset: Array
    axis: Array
    inertia: Array | None = None
    fixed: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """Joints from the base to the last link. gravity (3,) [m/s2], in the frame of the base."""

    joints: tuple[ChainJoint, ...]
    gravity: Array = field(default_factory=lambda: np.array([0.0, 0.0, -STANDARD_GRAVITY]))

    def __len__(self) -> int:
        return len(self.joints)

    @property
    def names(self) -> tuple[str, ...]:
        """Of its joints."""
        return tuple(joint.name for joint in self.joints)

    def named(self, names: Sequence[str]) -> Chain:
        """The same chain with its joints called so."""
        return replace(self, joints=tuple(replace(j, name=n) for j, n in zip(self.joints, names, strict=True)))

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Of all inertial parameters, link by link: `a1.m`, `a1.mx`, ..."""
        return tuple(f"{joint.name}.{symbol}" for joint in self.joints for symbol in PER_LINK)

    @property
    def weightless(self) -> Chain:
        """The same chain without gravity."""
        return replace(self, gravity=np.zeros(3))


def chain_of_rows(names: Sequence[str], rows: Sequence[DhRow], distal: bool, gravity: Array) -> Chain:
    """The chain that rows of Denavit and Hartenberg describe; its masses are unknown.

    In the distal convention the frame of a link sits on its own axis too, so a row's d, a and alpha place the next.
    """
    joints, rotation, offset = [], np.eye(3), np.zeros(3)
    for name, row in zip(names, rows, strict=True):
        tilt, length, turn, step = _about_x(row.alpha), np.array([row.a, 0, 0]), _about_z(row.theta), row.d
        if distal:
            placed, at = rotation @ turn, offset
            rotation, offset = tilt, np.array([row.a, 0.0, step])
        else:
            placed, at = tilt @ turn, length + tilt @ np.array([0.0, 0.0, step])
        joints.append(ChainJoint(name, placed, at, np.array([0.0, 0.0, float(row.sign)])))
    return Chain(tuple(joints), gravity)


def _about_x(angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def _about_z(angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
