"""The motion that a term acts on: that of its port, transformed by the transforms there, with the torque it reads.

Every quantity comes with its tangent, so derivatives pass through transforms and readings by themselves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from robotid.model.array import Array
from robotid.model.derivatives import Parts, Tangent, absent, combine
from robotid.model.geometry import Selection
from robotid.model.port import Port
from robotid.model.term import Motion, MotionTransform, Partials, Term


@dataclass(frozen=True, slots=True)
class Placed:
    """A term at its port, and where its own things are.

    at : slice of theta; x, v : the port's position and speed as sums over the state; q : its selection S of the
    coordinates; z : slice of its memory in the state; side : slice of its edges in the directions. reads_position,
    reads_acceleration : whether the term depends on these of its port at all. transform : the term
    where it transforms the motion rather than absorbs a torque; acts : False for a candidate, an effect at its null
    that takes part in the motion but adds nothing to it.
    """

    port: Port
    term: Term
    at: slice
    x: Selection
    v: Selection
    q: Selection
    z: slice
    side: slice
    reads_position: bool
    reads_acceleration: bool
    transform: MotionTransform | None
    acts: bool

    @property
    def effect(self) -> str:
        """The name of the term at its port, as structures and diagnoses have it."""
        return f"{self.port}.{self.term.name}"

    def values(self, theta: Array) -> list[float]:
        """The term's own of all parameters (p,)."""
        own: list[float] = theta[self.at].tolist()
        return own

    def tangent(self, d: Partials, *, parameters: bool = True) -> Tangent:
        """Derivatives to the term's own states and, where wanted, parameters; a candidate's states are none of the
        joint's."""
        states = dict(enumerate(d.z, start=self.z.start)) if self.acts and d.z else {}
        own = dict(enumerate(d.theta, start=self.at.start)) if parameters else {}
        return Tangent(_present(states), _present(own)) if states or own else NOTHING


NOTHING = Tangent()
"""The tangent of what depends on nothing. Tangents are shared, and none is changed once it is made."""


def _present(parts: Parts) -> Parts:
    return {key: value for key, value in parts.items() if not absent(value)}


@dataclass(slots=True)
class Lever:
    """Where a torque acts: on coordinate j, by factor c; dc is the tangent of a factor that changes, None of one that
    does not."""

    j: int
    c: Array | float
    dc: Tangent | None = None


@dataclass(frozen=True, slots=True)
class PortGeometry:
    """How a port moves: x, v, q as of `Placed`; angle : row of the state that is the motor's angle, None where the
    joint does not keep it.

    What follows from these is the same in every evaluation: levers : of a torque at the port; free_x : the position but
    for the motor's angle, and turn : its part in that; to_x, to_free_x, to_v : tangents of position and speed.
    """

    x: Selection
    v: Selection
    q: Selection
    angle: int | None
    levers: tuple[Lever, ...] = field(init=False)
    free_x: Selection = field(init=False)
    turn: float = field(init=False)
    to_x: Tangent = field(init=False)
    to_free_x: Tangent = field(init=False)
    to_v: Tangent = field(init=False)

    def __post_init__(self) -> None:
        free = tuple((j, c) for j, c in self.x if j != self.angle)
        follows = {
            "levers": tuple(Lever(j, c) for j, c in self.q),
            "free_x": free,
            "turn": sum(c for j, c in self.x if j == self.angle),
            "to_x": Tangent(dict(self.x)),
            "to_free_x": Tangent(dict(free)),
            "to_v": Tangent(dict(self.v)),
        }
        for name, value in follows.items():
            object.__setattr__(self, name, value)


@dataclass(slots=True)
class PortMotion:
    """A motion m, the tangents of its position, speed, direction and of the torque read, and the levers of a torque."""

    m: Motion
    x: Tangent
    v: Tangent
    s: Tangent
    tau: Tangent
    levers: tuple[Lever, ...]

    def chain(self, d: Partials, own: Tangent) -> Tangent:
        """Tangent of a quantity with these partials; own : that to the term's own states and parameters."""
        parts = ((d.x, self.x), (d.v, self.v), (d.s, self.s), (d.tau, self.tau))
        return combine([*(one for one in parts if one[1] is not NOTHING), (1.0, own)])

    def accelerated(self, a: Array) -> PortMotion:
        """The same motion at an acceleration (n,)."""
        m = self.m
        m = Motion(m.x, m.v, a, m.s, m.t, m.z, m.tau, m.xw, m.vw, m.side, m.w, m.dw, m.ddw)
        return PortMotion(m, self.x, self.v, self.s, self.tau, self.levers)


def transformed(
    place: Placed,
    before: PortMotion,
    m: Motion,
    watched: PortMotion | None,
    p: Sequence[float],
    *,
    parameters: bool = True,
) -> PortMotion:
    """The motion of a port behind one more transform.

    before : in front of it; m : the same motion with the transform's own memory and sides; watched : the motion of the
    port that the transform watches; parameters : whether derivatives to those of the transform are wanted.
    """
    transform = place.transform
    assert transform is not None
    if watched is not None:
        m = replace(m, xw=watched.m.x, vw=watched.m.v)
    dx, dv, ds = transform.transform_partials(m, p)

    def tangent(d: Partials) -> Tangent:
        along = before.chain(d, place.tangent(d, parameters=parameters))
        return along if watched is None else combine([(1.0, along), (d.xw, watched.x), (d.vw, watched.v)])

    levers = before.levers
    if watched is not None:
        # The new speed is linear in the watched one: at v = 0, vw = 1 its value is the lever, its slope the lever's.
        unit = transform.transform_partials(replace(m, v=np.zeros_like(m.v), vw=np.ones_like(m.v)), p)[1]
        turns = combine([(unit.xw, watched.x), (1.0, place.tangent(unit))])
        levers += tuple(Lever(lever.j, lever.c * dv.vw, combine([(lever.c, turns)])) for lever in watched.levers)
    if not place.acts:
        return _at_null(place, before, (tangent(dx), tangent(dv), tangent(ds)), levers)
    x, v, s = transform.transform(m, p)
    return PortMotion(before.m.moved(x, v, s), tangent(dx), tangent(dv), tangent(ds), before.tau, levers)


def _at_null(
    place: Placed, before: PortMotion, tangents: tuple[Tangent, Tangent, Tangent], levers: tuple[Lever, ...]
) -> PortMotion:
    """The motion as it was, for a candidate at its null changes nothing, with the derivatives to its parameters."""

    def own(tangent: Tangent) -> Parts:
        return {key: value for key, value in tangent.parameters.items() if key >= place.at.start}

    x, v, s = (
        Tangent(was.states, was.parameters | own(new))
        for was, new in zip((before.x, before.v, before.s), tangents, strict=True)
    )
    turned = tuple(
        Lever(lever.j, 0.0, Tangent({}, own(lever.dc)))
        for lever in levers[len(before.levers) :]
        if lever.dc is not None
    )
    return PortMotion(before.m, x, v, s, before.tau, before.levers + turned)
